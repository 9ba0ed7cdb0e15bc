#include "run_bake.h"
#include "terminal.h"

#include <iostream>
#include <utility>

namespace difusa {

namespace {

void print_details(const BakeResult& result) {
    for (const auto& [kind, choice] : result.plugins) {
        std::cout << kind << ": " << choice << "\n";
    }
    for (const auto& [phase, took] : result.journal.seconds()) {
        std::cout << "time, " << phase << ": " << format_seconds(took) << "\n";
    }
    for (std::size_t c = 0; c < result.solution.solve.residual_history.size(); ++c) {
        std::cout << "residuals, channel " << c << ":";
        for (const double residual : result.solution.solve.residual_history[c]) {
            std::cout << " " << residual;
        }
        std::cout << "\n";
    }
}

void print_result(const BakeResult& result, const BakeFiles& files, bool verbose) {
    if (verbose) {
        print_details(result);
    }
    std::cout << summary_of(result);
    if (!files.field.empty()) {
        std::cout << "written: " << files.field.string() << " (" << result.mesh.vertices.size() << " vertices, "
                  << result.mesh.triangles.size() << " triangles)\n";
    }
    for (const std::filesystem::path& file : files.beside_field()) {
        std::cout << "written: " << file.string() << "\n";
    }
}

/// What the command line leaves open is as in the bake.
void fill_in(BakeOptions& options, const BakeOptions& saved, const BakeArguments& arguments) {
    const auto as_saved = [&](const char* option, auto& choice, const auto& in_bake) {
        if (!arguments.given(option)) {
            choice = in_bake;
        }
    };
    as_saved("--direct", options.direct, saved.direct);
    as_saved("--shadow-rays", options.shadow_rays, saved.shadow_rays);
    as_saved("--visibility", options.visibility, saved.visibility);
    as_saved("--solver", options.solver, saved.solver);
    as_saved("--tolerance", options.solve.tolerance, saved.solve.tolerance);
    as_saved("--stop", options.stop, saved.stop);
    as_saved("--max-iterations", options.solve.max_iterations, saved.solve.max_iterations);
}

} // namespace

void run_bake(const BakeFiles& files, const RunArguments& run, bool verbose,
              const std::function<BakeResult(const Execution& execution)>& bake) {
    TerminalProgress progress(run.quiet);
    const Execution execution = run.execution(progress);
    BakeResult result;
    progress.watch([&] { result = bake(execution); });
    write_bake(result, files, execution);
    progress.clear();
    if (!run.quiet) {
        print_result(result, files, verbose);
    }
    require_target(result);
}

BakeResult with_transport(const std::filesystem::path& file, const BakeArguments& arguments, RelightOptions& how,
                          const Execution& execution, const std::function<BakeResult(const SavedTransport&)>& act) {
    Journal journal;
    const SavedTransport saved = load_transport(file, execution.with(execution.progress, &journal));
    journal.end();
    fill_in(how.bake, relight_defaults(saved), arguments);
    BakeResult result = act(saved);
    journal.append(result.journal); // loading comes first
    result.journal = std::move(journal);
    return result;
}

} // namespace difusa
