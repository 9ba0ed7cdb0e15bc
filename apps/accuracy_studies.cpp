#include "accuracy_studies.h"

#include <difusa/core/text.h>
#include <difusa/io/field_file.h>
#include <difusa/study/edge_study.h>
#include <difusa/study/gloss_study.h>
#include <difusa/study/method_study.h>
#include <difusa/study/mirror_study.h>
#include <difusa/study/ring_curves.h>
#include <difusa/study/shelf_study.h>
#include <difusa/study/subdivision_study.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <iostream>
#include <iterator>
#include <optional>
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

/// Root mean square of the differences between two curves, over that of the second.
double relative_rms(const std::vector<double>& curve, const std::vector<double>& exact) {
    double error = 0.0, size = 0.0;
    for (std::size_t i = 0; i < curve.size(); ++i) {
        error += (curve[i] - exact[i]) * (curve[i] - exact[i]);
        size += exact[i] * exact[i];
    }
    return size > 0.0 ? std::sqrt(error / size) : 0.0;
}

/// Gathered from each place: errors of patches are those of a few places at the edges of shadows, so that many places
/// matter more than what little noise these rays leave.
constexpr std::size_t rays_to_judge = 1024;

/// Throws UsageError if patches, of which each triangle has at least one, are far more than the sites wanted.
void check_triangles(const std::string& name, const Scene& scene, std::size_t sites) {
    if (const std::size_t triangles = scene.mesh.triangles.size(); triangles > 4 * sites) {
        throw UsageError(name + ": has " + std::to_string(triangles) +
                         " triangles, and patches are no larger; give more --sites, or name another scene");
    }
}

/// Of each case and file, according to a finer bake: the exact solution of a case is that of another surface, of which
/// its mesh is an approximation. Cases whose meshes are too fine for patches have coarser ones.
void for_each_known_light(const SideBySide& plan, const Registry& registry, const Execution& execution,
                          const std::function<void(const KnownLight&)>& compare) {
    BakeOptions fine = plan.common;
    fine.sites = plan.sites.back();
    fine = finer(fine);
    for (const std::string& name : plan.cases) {
        const std::optional<Scene> coarse = coarse_scene(name);
        const Scene scene = coarse ? *coarse : reference_case(name).scene;
        if (!coarse) {
            check_triangles(name, scene, plan.sites.back());
        }
        compare(evenly_known_light(bake(registry, scene, name, fine, execution), name, plan.how.places, rays_to_judge,
                                   execution));
    }
    for (const std::string& file : plan.scenes) {
        fine.when_visible = [&](const Scene& scene, const auto&...) {
            check_triangles(file, scene, plan.sites.back());
        };
        compare(
            evenly_known_light(bake(registry, file, fine, execution), file, plan.how.places, rays_to_judge, execution));
    }
}

std::string stem_of(const std::string& scene) {
    return std::filesystem::path(scene).stem().string();
}

struct NamedMethods {
    std::string name, title; ///< of the files; of the charts
    std::vector<ComparedMethod> methods;
};

void compare(const NamedMethods& comparison, const SideBySide& plan, const StudyOutput& output,
             const Registry& registry, const Execution& execution) {
    StudyTable table(output, method_header(), method_csv_header());
    for_each_known_light(plan, registry, execution, [&](const KnownLight& light) {
        const std::vector<MethodTrial> trials =
            compare_methods(registry, light, comparison.methods, plan.sites, execution,
                            [&](const MethodTrial& trial) { table.add(method_row(trial), method_csv_row(trial)); });
        write_whole_file(output.folder / (stem_of(light.name) + "_" + comparison.name + ".svg"),
                         method_chart(trials, comparison.title, plan.elsewhere));
    });
    table.write(comparison.name);
}

} // namespace

void check_chart_names(const std::vector<std::string>& cases, const std::vector<std::string>& scenes) {
    std::vector<std::string> stems = cases;
    for (const std::string& scene : scenes) {
        stems.push_back(stem_of(scene));
        if (std::count(stems.begin(), stems.end(), stems.back()) > 1) {
            throw UsageError("--scene " + scene + ": another one is named " + stems.back() +
                             ", too, and would have the same rows and charts: rename one of them");
        }
    }
}

void show(const Measurement& m) {
    std::cout << m.case_name << ", " << method_of(m) << ", spacing " << m.options.spacing << ", " << m.options.rays
              << " rays: ";
    if (m.failed) {
        std::cout << m.failure << std::endl;
        return;
    }
    std::cout << m.sites << " sites, " << text_of(m.seconds + m.seconds_output) << " s, relative L2 error "
              << text_of(m.total.l2.relative().value_or(NAN)) << std::endl;
}

void write_measurements(const std::vector<Measurement>& measurements, const std::vector<std::string>& cases,
                        const std::filesystem::path& folder) {
    write_whole_file(folder / "measurements.csv", csv_of(measurements));
    write_whole_file(folder / "measurements.json", json_of(measurements));
    for (const std::string& name : cases.empty() ? reference_case_names() : cases) {
        write_whole_file(folder / (name + ".md"), markdown_of(measurements, name));
        write_whole_file(folder / (name + "_error_against_time.svg"), error_against_time(measurements, name));
        write_whole_file(folder / (name + "_error_against_sites.svg"), error_against_sites(measurements, name));
    }
}

void write_estimates(const EstimatePlan& plan, const StudyOutput& output, const Registry& registry,
                     const Execution& execution) {
    StudyTable table(output, estimate_header(), estimate_csv_header());
    const auto judge = [&](const KnownLight& light, const BakeOptions& options) {
        std::string rows;
        const auto trials =
            try_estimate(registry, light, options, plan.bakes, execution,
                         [&](const EstimateTrial& trial) { rows += estimate_csv_row(light.name, trial); });
        table.add(estimate_row(light.name, trials), rows);
    };
    for (const std::string& name : plan.cases) {
        const ReferenceCase exact = reference_case(name);
        BakeOptions own = plan.common;
        if (!own.target && !(own.spacing > 0.0)) {
            own.spacing = exact.spacings.back();
        }
        // The exact solution is that of another surface, of which the mesh is an approximation: no residual of the
        // equation on the mesh sees the difference.
        judge(known_light(bake(registry, exact.scene, name, finer(own), execution), name, plan.how.places, execution),
              own);
    }
    for (const std::string& file : plan.scenes) {
        judge(known_light(bake(registry, file, finer(plan.common), execution), file, plan.how.places, execution),
              plan.common);
    }
    table.write("estimate");
}

void write_side_by_side(const SideBySide& plan, const StudyOutput& output, const Registry& registry,
                        const Execution& execution) {
    compare({"side_by_side", "classical and meshless", classical_and_meshless(plan.common)}, plan, output, registry,
            execution);
}

void write_defaults(const SideBySide& plan, const StudyOutput& output, const Registry& registry,
                    const Execution& execution) {
    compare({"defaults", "defaults and others", defaults_and_others(plan.common)}, plan, output, registry, execution);
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

void write_gloss(std::size_t sites, std::uint64_t seed, const StudyOutput& output, const Registry& registry,
                 const Execution& execution) {
    StudyTable table(output, gloss_header(), "");
    gloss_study(registry, sites, seed, execution, [&](const GlossTrial& trial) { table.add(gloss_row(trial), ""); });
    table.write("gloss");
}

void write_chapter7(const StudyPlan& plan, const StudyOutput& output, const Registry& registry,
                    const Execution& execution) {
    const ReferenceCase reference = reference_case("ball-over-disc");
    std::string table = "| transport | basis | spacing | sites | curve | mean of rings | one meridian |\n"
                        "|---|---|---|---|---|---|---|\n";
    std::string csv = "transport,basis,spacing,curve,place,mean,meridian,exact\n";
    for (const bool printed : {true, false}) {
        for (const std::string& basis : plan.bases) {
            for (const double spacing : plan.spacings) {
                BakeOptions options = plan.common;
                options.projection = "natural"; // as printed
                options.basis = basis;
                options.spacing = spacing;
                options.rays = plan.rays[0];
                options.output_spacing = reference.scene.mesh.diameter();
                options.error_points = 0;
                if (printed) { // T 5.5, 5.7: direct light is part of the unknown
                    options.transport = "pairwise:areas=neighbours";
                    options.kernel = "point";
                    options.direct = "interpolated";
                }
                const std::string transport = printed ? "pairwise" : "gather";
                const std::string row = "| " + transport + " | " + basis + " | " + text_of(spacing) + " | ";
                if (!output.quiet) {
                    std::cout << transport << ", " << basis << ", spacing " << spacing << std::endl;
                }
                try {
                    const BakeResult result = bake(registry, reference.scene, reference.name, options, execution);
                    for (const RingCurve& curve : ring_curves(result, reference, 100, 100, execution)) {
                        std::string name = transport + "_" + basis + "_" + text_of(spacing) + "_" + curve.name;
                        std::replace_if(
                            name.begin(), name.end(), [](char c) { return c == ',' || c == ' ' || c == ':'; }, '_');
                        write_whole_file(output.folder / (name + ".svg"),
                                         chart_of(curve, transport + ", " + basis + ", spacing " + text_of(spacing)));
                        std::array<char, 64> errors{};
                        std::snprintf(errors.data(), errors.size(), " | %.1e | %.1e |\n",
                                      relative_rms(curve.mean, curve.exact), relative_rms(curve.meridian, curve.exact));
                        table += row + std::to_string(result.sites->size()) + " | " + curve.name + errors.data();
                        for (std::size_t i = 0; i < curve.place.size(); ++i) {
                            csv += transport + ",\"" + basis + "\"," + text_of(spacing) + ",\"" + curve.name + "\"," +
                                   text_of(curve.place[i]) + "," + text_of(curve.mean[i]) + "," +
                                   text_of(curve.meridian[i]) + "," + text_of(curve.exact[i]) + "\n";
                        }
                    }
                } catch (const NotConverged& error) {
                    table += row + "– | does not converge | | |\n";
                    if (!output.quiet) {
                        std::cout << "  " << error.what() << std::endl;
                    }
                }
            }
        }
    }
    write_whole_file(output.folder / "chapter7.md", table);
    write_whole_file(output.folder / "chapter7.csv", csv);
}

void write_subdivision(const SideBySide& plan, const StudyOutput& output, const Registry& registry,
                       const Execution& execution) {
    StudyTable table(output, subdivision_header(), subdivision_csv_header());
    for_each_known_light(plan, registry, execution, [&](const KnownLight& light) {
        const std::vector<SubdivisionTrial> trials = compare_subdivision(
            registry, light, plan.common, plan.sites.front(), execution,
            [&](const SubdivisionTrial& trial) { table.add(subdivision_row(trial), subdivision_csv_row(trial)); });
        write_whole_file(output.folder / (stem_of(light.name) + "_subdivision.svg"), subdivision_chart(trials));
    });
    table.write("subdivision");
}

void write_shelves(const BakeOptions& options, const MeasureOptions& how, const StudyOutput& output,
                   const Registry& registry, const Execution& execution) {
    StudyTable table(output, shelf_header(), shelf_csv_header());
    shelf_study(registry, {1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0}, options, how, execution,
                [&](const ShelfTrial& trial) { table.add(shelf_row(trial), shelf_csv_row(trial)); });
    table.write("shelf");
}

void write_edges(const BakeOptions& options, const std::vector<double>& spacings, const MeasureOptions& how,
                 const StudyOutput& output, const Registry& registry, const Execution& execution) {
    StudyTable table(output, edge_header(spacings), edge_csv_header());
    edge_study(registry, {0.2, 0.5, 0.8, 0.95}, spacings, 0.02, options, how, execution,
               [&](const EdgeTrial& trial) { table.add(edge_row(trial), edge_csv_rows(trial)); });
    table.write("edges");
}

} // namespace difusa
