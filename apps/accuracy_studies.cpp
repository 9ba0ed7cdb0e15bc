#include "accuracy_studies.h"

#include <difusa/core/text.h>
#include <difusa/io/field_file.h>
#include <difusa/study/classical_study.h>
#include <difusa/study/mirror_study.h>

#include <algorithm>
#include <iostream>
#include <iterator>
#include <utility>

namespace difusa {

namespace {

/// A table in Markdown, printed as it grows unless the study is quiet, and the same as CSV.
class StudyTable {
  public:
    StudyTable(const StudyOutput& output, const std::string& header, std::string csv_header)
        : output_(output), csv_(std::move(csv_header)) {
        add(header, "");
    }

    void add(const std::string& row, const std::string& csv_rows) {
        if (!output_.quiet) {
            std::cout << row << std::flush;
        }
        table_ += row;
        csv_ += csv_rows;
    }

    /// NAME.md, and NAME.csv if there are any rows for it.
    void write(const std::string& name) const {
        write_whole_file(output_.folder / (name + ".md"), table_);
        if (!csv_.empty()) {
            write_whole_file(output_.folder / (name + ".csv"), csv_);
        }
    }

  private:
    const StudyOutput& output_;
    std::string table_, csv_;
};

} // namespace

void write_side_by_side(const SideBySide& plan, const StudyOutput& output, const Registry& registry,
                        const Execution& execution) {
    StudyTable table(output, method_header(), method_csv_header());
    const auto compare = [&](const KnownLight& light) {
        const std::vector<MethodTrial> trials =
            compare_methods(registry, light, plan.common, plan.sites, execution,
                            [&](const MethodTrial& trial) { table.add(method_row(trial), method_csv_row(trial)); });
        const std::string name = std::filesystem::path(light.name).stem().string();
        write_whole_file(output.folder / (name + "_side_by_side.svg"), method_chart(trials));
    };
    for (const std::string& name : plan.cases) {
        compare(known_light(Judge(reference_case(name), plan.how, execution)));
    }
    for (const std::string& file : plan.scenes) {
        BakeOptions fine = plan.common;
        fine.sites = plan.sites.back();
        compare(known_light(bake(registry, file, finer(fine), execution), file, plan.how.places, execution));
    }
    table.write("side_by_side");
}

void write_solvers(const SolverPlan& plan, const std::vector<std::string>& files, const StudyOutput& output,
                   const Registry& registry, const Execution& execution) {
    StudyTable table(output, solver_header(), solver_csv_header());
    for (const std::string& file : files) {
        const auto trials = try_solvers(registry, file, plan, execution, [&](const SolverTrial& trial) {
            table.add(solver_row(trial), solver_csv_rows(trial));
        });
        for (const double albedo : plan.albedos) {
            std::vector<SolverTrial> lines; // to the smallest residual
            std::copy_if(trials.begin(), trials.end(), std::back_inserter(lines), [&](const SolverTrial& trial) {
                return trial.albedo == albedo && trial.tolerance == plan.tolerances.back();
            });
            const std::string name = lines.front().scene + "_albedo_" + text_of(albedo);
            for (const auto& [axis, what] :
                 {std::pair(SolverAxis::iterations, "iterations.svg"), std::pair(SolverAxis::entries, "entries.svg"),
                  std::pair(SolverAxis::seconds, "seconds.svg")}) {
                write_whole_file(output.folder / (name + "_residual_against_" + what), residual_chart(lines, axis));
                write_whole_file(output.folder / (name + "_error_against_" + what), error_chart(lines, axis));
            }
        }
    }
    table.write("solvers");
}

void write_validation(const std::vector<ValidationCase>& cases, const BakeOptions& options, const StudyOutput& output,
                      const Registry& registry, const Execution& execution) {
    StudyTable table(output, validation_header(), validation_csv_header());
    for (const ValidationCase& one : cases) {
        const ValidationResult result = validate(registry, one, options, execution);
        table.add(validation_row(result), validation_csv_rows(result));
    }
    table.write("validation");
}

void write_mirrors(double spacing, std::uint64_t seed, const StudyOutput& output, const Registry& registry,
                   const Execution& execution) {
    StudyTable table(output, mirror_header(), "");
    mirror_study(registry, spacing, seed, execution,
                 [&](const MirrorTrial& trial) { table.add(mirror_row(trial), ""); });
    table.write("mirrors");
}

} // namespace difusa
