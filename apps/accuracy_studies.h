// Studies of measure_accuracy that write tables row by row: the error estimate, methods side by side, divided patches,
// solvers, published validation cases, form factors over mirror patches, gloss, shelves, edges.
#pragma once

#include <difusa/study/measure.h>
#include <difusa/study/method_study.h>
#include <difusa/study/solver_study.h>
#include <difusa/study/study.h>
#include <difusa/study/validation.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace difusa {

/// Where a study writes, and whether it prints its table too.
struct StudyOutput {
    std::filesystem::path folder;
    bool quiet = false;
};

/// Tables and charts of scenes have their stems. Throws UsageError if two have the same.
void check_chart_names(const std::vector<std::string>& cases, const std::vector<std::string>& scenes);

/// Prints a line.
void show(const Measurement& measurement);

/// measurements.csv, measurements.json, and a table and two charts of each case; no cases: all.
void write_measurements(const std::vector<Measurement>& measurements, const std::vector<std::string>& cases,
                        const std::filesystem::path& folder);

struct EstimatePlan {
    BakeOptions common;
    std::size_t bakes = 0;                  ///< of each
    std::vector<std::string> cases, scenes; ///< as for SideBySide; cases at their finest spacing if none is given
    MeasureOptions how;
};

/// How often the error estimate holds, and how close it is: estimate.md and estimate.csv.
void write_estimates(const EstimatePlan& plan, const StudyOutput& output, const Registry& registry,
                     const Execution& execution);

struct SideBySide {
    BakeOptions common;
    std::vector<std::size_t> sites;         ///< of each method, about
    std::vector<std::string> cases, scenes; ///< scenes of reference cases; files
    MeasureOptions how;
    std::vector<MeasuredElsewhere> elsewhere; ///< shown in the charts
};

/// The classical method beside the meshless one: side_by_side.md, side_by_side.csv, and a chart of each scene.
void write_side_by_side(const SideBySide& plan, const StudyOutput& output, const Registry& registry,
                        const Execution& execution);

/// The default options beside evenly spaced sites, each basis and the first version's defaults: defaults.md,
/// defaults.csv, and a chart of each scene.
void write_defaults(const SideBySide& plan, const StudyOutput& output, const Registry& registry,
                    const Execution& execution);

/// What dividing patches is worth, on scenes judged likewise: subdivision.md, subdivision.csv, and a chart of each
/// scene. Of `sites` the first counts.
void write_subdivision(const SideBySide& plan, const StudyOutput& output, const Registry& registry,
                       const Execution& execution);

/// Curves over the ball and the disc (T ch. 7), as printed and as implemented here, for the plan's bases, spacings and
/// number of rays: chapter7.md, chapter7.csv, and a chart of each curve.
void write_chapter7(const StudyPlan& plan, const StudyOutput& output, const Registry& registry,
                    const Execution& execution);

/// Solvers on the system of each file: solvers.md, solvers.csv, and charts of residual and error for each albedo.
void write_solvers(const SolverPlan& plan, const std::vector<std::string>& files, const StudyOutput& output,
                   const Registry& registry, const Execution& execution);

/// validation.md and validation.csv.
void write_validation(const std::vector<ValidationCase>& cases, const BakeOptions& options, const StudyOutput& output,
                      const Registry& registry, const Execution& execution);

/// Shelves of lengths 1, 2, 4, ..., 64 beside the infinite one: shelf.md and shelf.csv.
void write_shelves(const BakeOptions& options, const MeasureOptions& how, const StudyOutput& output,
                   const Registry& registry, const Execution& execution);

/// The light near edges of reflectances from 0.2 to 0.95, and the order of convergence there: edges.md and edges.csv.
void write_edges(const BakeOptions& options, const std::vector<double>& spacings, const MeasureOptions& how,
                 const StudyOutput& output, const Registry& registry, const Execution& execution);

/// mirrors.md. `spacing`: of the sites.
void write_mirrors(double spacing, std::uint64_t seed, const StudyOutput& output, const Registry& registry,
                   const Execution& execution);

/// gloss.md. `sites`: of each bake.
void write_gloss(std::size_t sites, std::uint64_t seed, const StudyOutput& output, const Registry& registry,
                 const Execution& execution);

} // namespace difusa
