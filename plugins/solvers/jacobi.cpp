// Solver `jacobi` (T 5.8): h <- g + T h, the Neumann series summed term by term: iteration i contains all light of up
// to i bounces. Converges at the rate of the spectral radius of T, at most the largest reflectance for gathered
// transport.
#include <difusa/algebra/solver.h>
#include <difusa/plugin/plugin.h>

#include <cmath>

namespace {

using difusa::SolveSummary;
using difusa::Values;

class Jacobi final : public difusa::Solver {
  public:
    explicit Jacobi(const difusa::Parameters& /*parameters*/) {}

    SolveSummary solve(const difusa::SolveProblem& problem, const difusa::SolveOptions& options,
                       const difusa::Execution& execution) const override {
        SolveSummary summary;
        summary.h = problem.g;
        summary.residual_history.resize(static_cast<std::size_t>(summary.h.cols()));
        double first = 0.0;
        for (;; ++summary.iterations) {
            execution.check();
            Values r; // r = g + T h - h
            const std::vector<double> relative = difusa::relative_residual(problem, summary.h, r, execution);
            for (std::size_t c = 0; c < relative.size(); ++c) {
                summary.residual_history[c].push_back(relative[c]);
            }
            summary.residual = relative[0];
            for (const double r_c : relative) { // NaN counts as largest
                summary.residual = r_c <= summary.residual ? summary.residual : r_c;
            }
            first = summary.iterations == 0 ? summary.residual : first;
            bool converged = true;
            for (Eigen::Index c = 0; c < r.cols(); ++c) {
                const double largest = r.col(c).cwiseAbs().maxCoeff(), h = summary.h.col(c).cwiseAbs().maxCoeff();
                converged = converged && (relative[static_cast<std::size_t>(c)] <= options.tolerance ||
                                          difusa::is_rounding(largest, h));
            }
            if (converged) {
                summary.reason = SolveSummary::Reason::converged;
                return summary;
            }
            if (!std::isfinite(summary.residual) || summary.residual > 1e6 * std::max(first, 1.0)) {
                summary.reason = SolveSummary::Reason::diverged;
                return summary;
            }
            if (summary.iterations == options.max_iterations) {
                summary.reason = SolveSummary::Reason::max_iterations;
                return summary;
            }
            summary.h += r; // h <- g + T h
        }
    }
};

} // namespace

DIFUSA_PLUGIN(solver, "jacobi", Jacobi, "Neumann series, one bounce per iteration (T 5.8).", {})
