#include <difusa/algebra/solver.h>

#include <difusa/core/error.h>

#include <sstream>

namespace difusa {

std::string SolveSummary::sentence() const {
    std::ostringstream text;
    switch (reason) {
    case Reason::converged:
        text << (to_rounding ? "converged to rounding" : "converged");
        break;
    case Reason::max_iterations:
        text << "stopped at the limit of iterations";
        break;
    case Reason::diverged:
        text << "diverged";
        break;
    case Reason::stagnated:
        text << "stagnated";
        break;
    }
    text << " after " << iterations << (iterations == 1 ? " iteration" : " iterations") << ", relative residual "
         << residual;
    if (change) {
        text << ", relative change " << *change;
    }
    return text.str();
}

std::string SolveSummary::remedy() const {
    return reason == Reason::diverged ? "use a smaller relaxation, or --solver krylov"
                                      : "allow more --max-iterations, a larger --tolerance, or another --solver";
}

SolveSummary judged(SolveSummary summary, const SolveOptions& options) {
    const double reached =
        options.stop == StopBy::residual ? summary.residual : summary.change.value_or(options.tolerance);
    summary.to_rounding = summary.converged() && !(reached <= options.tolerance);
    return summary;
}

std::shared_ptr<const Factors> factors_for(const char* solver, const LinearOperator& T, const Execution& execution) {
    std::shared_ptr<const Factors> factors = T.factors(execution);
    if (!factors) {
        throw UsageError(std::string("--solver ") + solver +
                         ": relaxes one unknown after the other, and needs rows and columns that this operator does "
                         "not have; use krylov or jacobi");
    }
    return factors;
}

std::vector<double> relative_residual(const SolveProblem& problem, const Values& h, Values& residual,
                                      const Execution& execution) {
    problem.T->apply(h, residual, execution);
    residual += problem.g - h;
    std::vector<double> relative;
    for (Eigen::Index c = 0; c < h.cols(); ++c) {
        // NaN in the light or the residual must propagate to the result, not be lost in a comparison.
        const double light = problem.g.col(c).cwiseAbs().maxCoeff<Eigen::PropagateNaN>();
        const double largest = residual.col(c).cwiseAbs().maxCoeff<Eigen::PropagateNaN>();
        relative.push_back(light == 0.0 ? 0.0 : largest / light);
    }
    return relative;
}

} // namespace difusa
