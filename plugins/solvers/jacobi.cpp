// Solver `jacobi` (T 5.8, L 60): h <- g + T h, the Neumann series summed term by term: iteration i contains all light
// of up to i bounces. Converges at the rate of the spectral radius of T, at most the largest reflectance for gathered
// transport.
//   relaxation  omega in h <- h + omega (g + T h - h), 1. All unknowns change together, so that the rate is the largest
//               |1 - omega (1 - lambda)| over the eigenvalues lambda of T: above 1 it helps only as far as no
//               eigenvalue is much below 0 (L 48, 65)
#include <difusa/algebra/solver.h>
#include <difusa/plugin/plugin.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace {

using difusa::SolveSummary;
using difusa::Values;

class Jacobi final : public difusa::Solver {
  public:
    explicit Jacobi(const difusa::Parameters& parameters) : relaxation_(parameters.real("relaxation")) {}

    SolveSummary solve(const difusa::SolveProblem& problem, const difusa::SolveOptions& options,
                       const difusa::Execution& execution) const override {
        SolveSummary summary;
        summary.h = problem.g;
        summary.residual_history.resize(static_cast<std::size_t>(summary.h.cols()));
        difusa::Showing showing(options);
        const auto n = static_cast<std::size_t>(summary.h.rows());
        const std::size_t product = static_cast<std::size_t>(summary.h.cols()) * problem.T->entry_count();
        double first = 0.0;
        std::vector<double> change; // of the last iteration, for each column
        for (;; ++summary.iterations) {
            execution.check();
            Values r; // r = g + T h - h
            const std::vector<double> relative = difusa::relative_residual(problem, summary.h, r, execution);
            summary.entries_touched += product;
            summary.residual = relative[0];
            for (std::size_t c = 0; c < relative.size(); ++c) {
                summary.residual_history[c].push_back(relative[c]);
                summary.residual = difusa::larger(summary.residual, relative[c]);
            }
            first = summary.iterations == 0 ? summary.residual : first;
            const auto show = [&] {
                showing.show({static_cast<std::size_t>(summary.iterations) * n, summary.entries_touched,
                              summary.residual, summary.h});
            };
            const bool ends = end(summary, relative, change, first, r, options);
            if (ends || showing.is_due(static_cast<std::size_t>(summary.iterations) * n)) {
                show();
            }
            if (ends) {
                return difusa::judged(std::move(summary), options);
            }
            change = relative;
            for (double& of_column : change) {
                of_column *= relaxation_;
            }
            summary.h += relaxation_ == 1.0 ? r : Values(relaxation_ * r); // h <- g + T h
        }
    }

  private:
    /// Whether to end, and why.
    static bool end(SolveSummary& summary, const std::vector<double>& relative, const std::vector<double>& change,
                    double first, const Values& r, const difusa::SolveOptions& options) {
        const bool by_change = options.stop == difusa::StopBy::change;
        bool converged = true;
        for (std::size_t c = 0; c < relative.size(); ++c) {
            const auto column = static_cast<Eigen::Index>(c);
            const bool enough =
                !by_change ? relative[c] <= options.tolerance : !change.empty() && change[c] <= options.tolerance;
            converged =
                converged &&
                (enough || difusa::is_rounding(r.col(column).cwiseAbs().maxCoeff<Eigen::PropagateNaN>(),
                                               summary.h.col(column).cwiseAbs().maxCoeff<Eigen::PropagateNaN>()));
        }
        if (by_change && !change.empty()) {
            summary.change = *std::max_element(change.begin(), change.end());
        }
        if (converged) {
            summary.reason = SolveSummary::Reason::converged;
        } else if (!std::isfinite(summary.residual) || summary.residual > 1e6 * std::max(first, 1.0)) {
            summary.reason = SolveSummary::Reason::diverged;
        } else if (summary.iterations == options.max_iterations) {
            summary.reason = SolveSummary::Reason::max_iterations;
        } else {
            return false;
        }
        return true;
    }

    double relaxation_;
};

} // namespace

DIFUSA_PLUGIN(
    solver, "jacobi", Jacobi, "Neumann series, one bounce per iteration (T 5.8).",
    {{"relaxation", difusa::ParameterSpec::Type::real, "1", "share of the residual that is added", 0.05, 1.95, {}}})
