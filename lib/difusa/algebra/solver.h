// Plugin kind "solver": (I - T) h = g by iteration.
#pragma once

#include <difusa/algebra/linear_operator.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
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

/// What an iteration is judged by when it is to end; per column, relative to max|g|.
enum class StopBy {
    residual, ///< the largest residual, max|g + T h - h|
    change    ///< the largest change of h in an iteration
};

/// An approximation on the way to the solution.
struct Iterate {
    std::size_t relaxations = 0; ///< unknowns that were relaxed so far, of the column with most; #points an iteration
    std::size_t entries = 0;     ///< matrix entries multiplied so far
    double residual = 0.0;       ///< the largest relative residual that the solver knows of
    const Values& h;             ///< what is to be displayed, #points by #columns, W/m²
};

struct SolveOptions {
    double tolerance = 1e-6; ///< on the largest residual or change; a residual within rounding is also accepted
    int max_iterations = 1000;
    /// False: what the iteration knows of the residual may end it, without a product that confirms it.
    bool confirm = true;
    StopBy stop = StopBy::residual;
    /// Receives iterates: the first, that after one relaxation or one iteration, and later ones whenever there were
    /// half as many relaxations more, up to the last. May be empty; what it throws ends the iteration.
    std::function<void(const Iterate&)> watch = {};
};

/// When iterates are shown to SolveOptions::watch.
class Showing {
  public:
    explicit Showing(const SolveOptions& options) : watch_(options.watch) {}

    bool wanted() const { return static_cast<bool>(watch_); }

    /// The number of relaxations after which the next one is due.
    std::size_t next() const { return next_; }
    bool is_due(std::size_t relaxations) const { return wanted() && relaxations >= next_; }

    void show(const Iterate& iterate) {
        if (wanted()) {
            watch_(iterate);
            next_ = iterate.relaxations + std::max<std::size_t>(1, iterate.relaxations / 2);
        }
    }

  private:
    std::function<void(const Iterate&)> watch_;
    std::size_t next_ = 0;
};

/// The result, and why the iteration ended.
struct SolveSummary {
    enum class Reason { converged, max_iterations, diverged, stagnated };
    Reason reason = Reason::converged;
    int iterations = 0; ///< applications of T, or #points relaxations, begun; maximum over the columns
    /// Per column: relative residual after 0, 1, ... iterations. The last is computed afresh from the result
    /// (SolveOptions::confirm). Methods
    /// that relax one unknown after the other enter what they know of the others without a product: `gauss-seidel` the
    /// largest residual met in a sweep, `progressive` the largest unshot irradiance.
    std::vector<std::vector<double>> residual_history;
    double residual = 0.0;        ///< the last one, maximum over the columns
    std::optional<double> change; ///< of the last iteration, relative, maximum over the columns; if it was to stop it
    /// Converged, but not to the tolerance: what is left is rounding.
    bool to_rounding = false;
    std::size_t entries_touched = 0; ///< matrix entries multiplied, summed over the columns
    Values h;                        ///< #points by #columns, W/m²

    bool converged() const { return reason == Reason::converged; }
    /// One sentence for the user.
    std::string sentence() const;
    /// What the user can do if it has not converged, to follow "...: ".
    std::string remedy() const;
};

class Solver {
  public:
    virtual ~Solver() = default;

    /// True if T must have factors (LinearOperator::factors).
    virtual bool needs_factors() const { return false; }

    /// True if the columns of a factor are stored once more.
    virtual bool needs_columns() const { return false; }

    /// Throws UsageError if T does not have the factors that the method needs.
    virtual SolveSummary solve(const SolveProblem& problem, const SolveOptions& options,
                               const Execution& execution) const = 0;
};

/// The factors of T. Throws UsageError, naming the solver and the remedy, if there are none.
std::shared_ptr<const Factors> factors_for(const char* solver, const LinearOperator& T, const Execution& execution);

/// The larger of two; NaN counts as largest.
inline double larger(double a, double b) {
    return a <= b || std::isnan(b) ? b : a;
}

/// The same with `to_rounding` as the tolerance says.
SolveSummary judged(SolveSummary summary, const SolveOptions& options);

/// max|g + T h - h| / max|g| for each column (0 for a dark one), and the residual g + T h - h itself.
std::vector<double> relative_residual(const SolveProblem& problem, const Values& h, Values& residual,
                                      const Execution& execution);

} // namespace difusa
