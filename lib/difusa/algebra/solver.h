// Plugin kind "solver": (I - T) h = g by iteration.
#pragma once

#include <difusa/algebra/linear_operator.h>

#include <cmath>
#include <string>
#include <vector>

namespace difusa {

/// The equation h = g + T h: T gathers the reflected part of the irradiance h, g is the irradiance that arrives
/// otherwise. One column for each channel and set of lights; T may act differently on each column.
struct SolveProblem {
    const LinearOperator* T = nullptr;
    Values g; ///< #points by #columns, W/m²
};

/// A residual of this fraction of max|h| is rounding: of sums over the rays of a point, of which there may be hundreds.
inline constexpr double rounding_of_residual = 0x1p-46;

/// Whether a residual with the largest entry max|r| is mere rounding of a solution with max|h|. False unless both are
/// finite.
inline bool is_rounding(double largest_residual, double largest_solution) {
    return std::isfinite(largest_solution) && largest_residual <= rounding_of_residual * largest_solution;
}

struct SolveOptions {
    double tolerance = 1e-6; ///< on max|g + T h - h| / max|g|, per column; a residual within rounding is also accepted
    int max_iterations = 1000;
};

/// The result, and why the iteration ended.
struct SolveSummary {
    enum class Reason { converged, max_iterations, diverged, stagnated };
    Reason reason = Reason::converged;
    int iterations = 0;                                ///< applications of T, maximum over the columns
    std::vector<std::vector<double>> residual_history; ///< per column: relative residual after 0, 1, ... iterations
    double residual = 0.0;                             ///< the last one, maximum over the columns
    Values h;                                          ///< #points by #columns, W/m²

    bool converged() const { return reason == Reason::converged; }
    /// One sentence for the user.
    std::string sentence() const;
};

class Solver {
  public:
    virtual ~Solver() = default;
    virtual SolveSummary solve(const SolveProblem& problem, const SolveOptions& options,
                               const Execution& execution) const = 0;
};

/// max|g + T h - h| / max|g| for each column (0 for a dark one), and the residual g + T h - h itself.
std::vector<double> relative_residual(const SolveProblem& problem, const Values& h, Values& residual,
                                      const Execution& execution);

} // namespace difusa
