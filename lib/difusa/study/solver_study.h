// Solvers against each other: iterations, matrix entries and time that each needs on the same system.
#pragma once

#include <difusa/bake.h>

#include <functional>
#include <string>
#include <vector>

namespace difusa {

/// What is known of an iterate that a solver shows.
struct SolverStep {
    double iterations = 0.0; ///< relaxations per unknown
    double entries = 0.0;    ///< matrix entries multiplied
    double seconds = 0.0;    ///< without what it took to find out
    double residual = 0.0;   ///< max|g + T h - h| / max|g| of the iterate h, computed afresh
    double error = 0.0; ///< ‖h - h*‖₂ / ‖h*‖₂, h* the solution: how far the picture is from the last one
};

/// One solver on one system.
struct SolverTrial {
    std::string scene, solver;
    double albedo = 0.0, tolerance = 0.0;
    std::size_t points = 0;
    double product = 0.0; ///< matrix entries of one product with T
    SolveSummary::Reason reason = SolveSummary::Reason::converged;
    std::string sentence; ///< SolveSummary::sentence
    int iterations = 0;
    double entries = 0.0, seconds = 0.0;
    std::vector<SolverStep> steps; ///< the first, and then the more apart the later

    /// The first of the steps whose error, and that of all later ones, is at most this; null if there is none.
    const SolverStep* close_to(double error) const;
};

struct SolverPlan {
    std::vector<std::string> solvers;
    std::vector<double> albedos;    ///< of the whole surface, each in (0, 1)
    std::vector<double> tolerances; ///< on the largest residual
    BakeOptions bake;
};

/// Bakes the scene of a file once for its transport, and solves for one channel, the mean of its lights, with each
/// albedo, tolerance and solver. The light is carried over its first reflection by the operator, and all solvers start
/// from there. `tell` is called with each trial. Throws UsageError for an albedo that is not in (0, 1), and what a bake
/// throws.
std::vector<SolverTrial> try_solvers(const Registry& registry, const std::filesystem::path& file,
                                     const SolverPlan& plan, const Execution& execution,
                                     const std::function<void(const SolverTrial&)>& tell);

/// A row of a Markdown table, and its header: scene, albedo, tolerance, solver; iterations until the error was at most
/// 0.05; iterations, entries in products with T, seconds; or why it ended otherwise.
std::string solver_header();
std::string solver_row(const SolverTrial& trial);

/// One row per step, and the header.
std::string solver_csv_header();
std::string solver_csv_rows(const SolverTrial& trial);

/// What the residual, or the error, is drawn against.
enum class SolverAxis { iterations, entries, seconds };

/// Charts as SVG of trials of one scene, albedo and tolerance: a line for each solver.
std::string residual_chart(const std::vector<SolverTrial>& trials, SolverAxis axis);
std::string error_chart(const std::vector<SolverTrial>& trials, SolverAxis axis);

} // namespace difusa
