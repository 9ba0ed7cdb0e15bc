#include "relight_studies.h"
#include "terminal.h"

#include <difusa/core/memory.h>
#include <difusa/core/text.h>
#include <difusa/io/whole_file.h>
#include <difusa/output/daylight_files.h>
#include <difusa/output/gradient_table.h>
#include <difusa/radiosity/goal_gradient.h>
#include <difusa/study/operator_study.h>

#include <initializer_list>
#include <iostream>

namespace difusa {

namespace {

constexpr std::size_t rays_of_gradients = 65536; ///< from the places of a goal together

void declare_daylight(CLI::App& app, StudyArguments& a) {
    const std::string group = "Daylight coefficients (no field is written)";
    app.add_option(
           "--daylight", a.daylight,
           "irradiance of the places of --at and --grid, or else of the output vertices, for a radiance of 1 of "
           "each part of the sky: .mtx (Radiance) or .npz (NumPy)")
        ->group(group)
        ->type_name("FILE");
    add_parsed(app, "--sky-parts", a.request.factor,
               "division of the sky: 1 for Tregenza's 145 parts, 2 for Reinhart's 577, 4 for 2305, ... (default: 1), "
               "and the ground",
               [](const std::string& option, const std::string& text) {
                   const int factor = parse_whole<int>(option, text, 1);
                   if (factor > SkyDivision::most) {
                       throw UsageError(option + " " + text + ": must be at most " + std::to_string(SkyDivision::most));
                   }
                   return factor;
               })
        ->group(group)
        ->type_name("N");
    add_whole<std::size_t>(app, "--daylight-rays", a.request.rays, 1,
                           "rays from each place, about; at least one into each part")
        ->group(group)
        ->type_name("N")
        ->default_str(shown(a.request.rays));
    app.add_option("--daylight-from", a.daylight_from, "coefficients to use, .mtx; no transport is needed")
        ->group(group)
        ->type_name("FILE");
    app.add_option("--daylight-sky", a.sky,
                   "a sky: cie:type=12,elevation=40,azimuth=180,illuminance=20000 or perez:direct=700,diffuse=120,"
                   "elevation=40,azimuth=180")
        ->group(group)
        ->type_name("SKY");
    app.add_option("--daylight-output", a.under_sky, "table of what the places receive under it, .csv")
        ->group(group)
        ->type_name("FILE");
}

/// The light of the places under the sky of the command line.
void write_under_sky(const StudyArguments& a, const DaylightCoefficients& coefficients, const SkyDivision& sky,
                     const std::vector<SurfacePoint>& points, bool quiet) {
    const SkyInParts chosen = sky_in_parts(a.sky, sky);
    WholeFile file(a.under_sky);
    file.write(daylight_table(coefficients.irradiance(chosen.radiance), points));
    file.commit();
    if (!quiet) {
        std::cout << "sky: " << chosen.text << "\n";
        for (const std::string& note : chosen.notes) {
            std::cout << "note: " << note << "\n";
        }
        std::cout << "written: " << a.under_sky.string() << "\n";
    }
}

void run_daylight(const StudyArguments& a, BakeResult& result, const RunArguments& run, TerminalProgress& progress,
                  const Execution& execution) {
    std::optional<DaylightMatrix> matrix;
    progress.watch([&] { matrix = daylight_matrix(result, a.request, execution); });
    progress.clear();
    write_daylight(*matrix, result.photometric, a.daylight);
    if (!run.quiet) {
        for (const std::string& note : result.journal.notes()) {
            std::cout << "note: " << note << "\n";
        }
        std::cout << "written: " << a.daylight.string() << " (" << matrix->points.size() << " points, "
                  << matrix->sky.count() << " parts of the sky with the ground; " << matrix->coefficients.rays
                  << " rays from the points, " << matrix->coefficients.site_rays << " from the sites)\n";
    }
    if (!a.sky.empty()) {
        write_under_sky(a, matrix->coefficients, matrix->sky, matrix->points, run.quiet);
    }
}

void run_gradients(const StudyArguments& a, const BakeResult& result, const RunArguments& run,
                   TerminalProgress& progress, const Execution& execution) {
    std::vector<GoalGradient> gradients;
    progress.watch([&] {
        execution.phase("gradients");
        gradients = goal_gradients(result.solution, result.goals, rays_of_gradients, result.options.seed,
                                   result.options.solve, execution);
    });
    progress.clear();
    WholeFile file(a.gradients);
    file.write(gradient_table(result, gradients, a.faces));
    file.commit();
    if (!run.quiet) {
        std::cout << "written: " << a.gradients.string() << " (" << gradients.size()
                  << (gradients.size() == 1 ? " goal)\n" : " goals)\n");
    }
}

void run_operators(const StudyArguments& a, const BakeResult& result, const RunArguments& run,
                   TerminalProgress& progress, const Execution& execution) {
    std::vector<OperatorTrial> trials;
    progress.watch([&] { trials = try_operators(result, a.operators, execution, [](const OperatorTrial&) {}); });
    progress.clear();
    WholeFile file(a.operator_table);
    file.write(operator_csv(trials));
    file.commit();
    if (run.quiet) {
        return;
    }
    for (const OperatorTrial& trial : trials) {
        std::cout << trial.choice << ", " << trial.light << ": error " << text_of(trial.measured)
                  << " (stated: " << text_of(trial.stated) << "), " << text_of(trial.seconds)
                  << " s of processor time (iteration: " << text_of(trial.iteration_seconds)
                  << " s; to form it: " << text_of(trial.prepare_seconds) << " s), "
                  << format_bytes(static_cast<double>(trial.bytes)) << "\n";
    }
    std::cout << "written: " << a.operator_table.string() << "\n";
}

/// Refuses options that would do nothing.
void check_needless(const StudyArguments& a, const BakeArguments& bake) {
    const auto refuse_given = [&](std::initializer_list<const char*> options, const std::string& why) {
        for (const char* const option : options) {
            if (bake.given(option)) {
                throw UsageError(std::string(option) + ": has no effect " + why + ": omit it");
            }
        }
    };
    if (a.without_field()) {
        refuse_given({"--final-gather", "--face-centres", "--error-points", "--light-groups"},
                     "where no field is evaluated");
    }
    if (a.daylight.empty()) {
        refuse_given({"--sky-parts", "--daylight-rays"}, "without --daylight");
    }
    if (!a.daylight.empty()) {
        refuse_given({"--goal"}, "on daylight coefficients");
    }
    if (!a.operator_table.empty()) {
        refuse_given({"--at", "--grid", "--goal", "--north", "--output-spacing"}, "on rendering operators");
    }
    if (!a.gradients.empty()) {
        refuse_given({"--at", "--grid", "--first-bounce", "--output-spacing"}, "on gradients");
    }
    if (!a.daylight_from.empty()) {
        refuse_given({"--at", "--grid", "--goal", "--north", "--scene", "--scale", "--emission", "--reflectance",
                      "--sun", "--point-light", "--sky", "--output-spacing"},
                     "on coefficients from a file");
    }
}

} // namespace

void declare_studies(CLI::App& app, StudyArguments& a) {
    declare_daylight(app, a);
    const std::string group = "Gradients and lamps";
    app.add_option("--gradients", a.gradients,
                   "how the means of the goals of --goal depend on light groups, emissions and reflectances, .csv (no "
                   "field is written)")
        ->group(group)
        ->type_name("FILE");
    app.add_flag("--face-gradients", a.faces, "and on the emission of each face")->group(group);
    add_parsed(app, "--solve-lamps", a.lamps,
               "scale the lamps so that the places of --at and --grid come as near to this level as possible, in lux "
               "(W/m^2 if the scene does not measure its lights in lux)",
               parse_positive)
        ->group(group)
        ->type_name("LEVEL");
    const std::string operators = "Rendering operators (no field is written)";
    app.add_option("--operator-table", a.operator_table,
                   "all reflections as one product, by each --operator, against the iteration: error for each light "
                   "group, time and memory, .csv")
        ->group(operators)
        ->type_name("FILE");
    add_repeated(app, "--operator", a.operators,
                 "neumann:bounces=8, dense, or low-rank:rank=64,bounces=1 (may be repeated)",
                 [](const std::string&, const std::string& text) { return parse_operator(text); })
        ->group(operators)
        ->type_name("CHOICE");
}

void check_studies(const StudyArguments& a, const BakeArguments& bake, bool path) {
    const auto refuse = [](const std::string& what) { throw UsageError(what); };
    if (a.without_field() && !bake.files.field.empty()) {
        refuse(bake.files.field.string() +
               ": with --daylight, --gradients and --operator-table no field is written: omit it");
    }
    if (path && (a.without_field() || a.lamps)) {
        refuse("--sun-path cannot be combined with --daylight, --daylight-from, --gradients, --solve-lamps or "
               "--operator-table: omit one");
    }
    if (!a.daylight.empty() + !a.daylight_from.empty() + !a.gradients.empty() + !a.operator_table.empty() > 1) {
        refuse("--daylight, --daylight-from, --gradients and --operator-table: give one of them");
    }
    if (a.operator_table.empty() != a.operators.empty()) {
        refuse("--operator and --operator-table go together; a single light is soonest found by iteration, as "
               "without them");
    }
    if (a.without_field() &&
        (a.lamps || !bake.files.listed.empty() || !bake.files.report.empty() || !bake.files.sites.empty())) {
        refuse("--solve-lamps, --at-output, --report and --sites-output belong to a field: omit them");
    }
    if (a.sky.empty() != a.under_sky.empty() || (!a.sky.empty() && a.daylight.empty() && a.daylight_from.empty())) {
        refuse("--daylight-sky and --daylight-output go together, with --daylight or --daylight-from");
    }
    if (!a.daylight_from.empty() && a.sky.empty()) {
        refuse("--daylight-from: needs a sky, --daylight-sky, and --daylight-output");
    }
    if (!a.gradients.empty() && bake.goal.empty()) {
        refuse("--gradients: needs goals, --goal FILE.json");
    }
    if (a.gradients.empty() && a.faces) {
        refuse("--face-gradients: needs --gradients");
    }
    if (!a.daylight.empty()) {
        check_daylight_file(a.daylight);
    }
    if (!a.sky.empty()) { // before the coefficients, which take a while
        (void)sky_in_parts(a.sky, SkyDivision(1, Vec3::UnitZ(), Vec3::UnitY()));
    }
    check_needless(a, bake);
}

std::vector<OutputName> outputs_of(const StudyArguments& a) {
    return {{a.daylight, false}, {a.under_sky, false}, {a.gradients, false}, {a.operator_table, false}};
}

void run_studies(const StudyArguments& a, const RunArguments& run, const SolveRelit& solve) {
    if (!a.daylight_from.empty()) {
        const DaylightTable table = read_daylight(a.daylight_from);
        write_under_sky(a, table.coefficients, table.sky, {}, run.quiet);
        return;
    }
    TerminalProgress progress(run.quiet);
    const Execution execution = run.execution(progress);
    BakeResult result;
    progress.watch([&] { result = solve(execution); });
    if (!a.daylight.empty()) {
        run_daylight(a, result, run, progress, execution);
    } else if (!a.operator_table.empty()) {
        run_operators(a, result, run, progress, execution);
    } else {
        run_gradients(a, result, run, progress, execution);
    }
}

} // namespace difusa
