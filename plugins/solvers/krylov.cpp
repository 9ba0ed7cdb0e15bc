// Solver `krylov`: restarted GMRES (Saad and Schultz 1986) on A h = H_direct, A = I - K diag(rho), a channel at a time.
// Its residual never grows, and it needs far fewer applications of K than `jacobi` where the reflectance is near 1.
#include <difusa/algebra/solver.h>
#include <difusa/plugin/plugin.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace {

using difusa::SolveSummary;
using difusa::Values;
using Vector = Eigen::VectorXd;

/// The largest absolute entry; NaN if there is one.
double largest(const Vector& x) {
    return x.cwiseAbs().maxCoeff<Eigen::PropagateNaN>();
}

class Krylov final : public difusa::Solver {
  public:
    explicit Krylov(const difusa::Parameters& parameters) : restart_(parameters.integer("restart")) {}

    SolveSummary solve(const difusa::SolveProblem& problem, const difusa::SolveOptions& options,
                       const difusa::Execution& execution) const override {
        SolveSummary summary;
        summary.h = Values::Zero(problem.H_direct.rows(), problem.H_direct.cols());
        for (Eigen::Index c = 0; c < summary.h.cols(); ++c) {
            Channel channel{problem, c, options, execution, {}, {}, 0, SolveSummary::Reason::converged};
            channel.solve(restart_);
            summary.h.col(c) = channel.h;
            const double residual = channel.history.back();
            summary.residual = residual <= summary.residual ? summary.residual : residual; // NaN is larger than all
            summary.residual_history.push_back(std::move(channel.history));
            summary.iterations = std::max(summary.iterations, channel.iterations);
            if (channel.reason != SolveSummary::Reason::converged) {
                summary.reason = channel.reason;
            }
        }
        return summary;
    }

  private:
    struct Channel {
        const difusa::SolveProblem& problem;
        Eigen::Index c;
        const difusa::SolveOptions& options;
        const difusa::Execution& execution;
        Vector h;
        std::vector<double> history;
        int iterations;
        SolveSummary::Reason reason;

        /// A x = x - K (rho ∘ x)
        Vector A(const Vector& x) const {
            if (execution.progress != nullptr) {
                execution.progress->check();
            }
            const Values b = problem.rho.col(c).cwiseProduct(x);
            Values y;
            problem.K->apply(b, y, execution);
            return x - y.col(0);
        }

        void solve(long restart) {
            const Vector H = problem.H_direct.col(c);
            const double light = largest(H);
            h = H; // one bounce short of nothing: a better start than zero, and its residual is the first bounce
            if (light == 0.0) {
                history.push_back(0.0);
                return;
            }
            Vector r = H - A(h);
            history.push_back(largest(r) / light);
            while (!(history.back() <= options.tolerance)) {
                if (!std::isfinite(history.back())) {
                    reason = SolveSummary::Reason::diverged;
                    return;
                }
                const double before = history.back();
                cycle(restart, light, r);
                r = H - A(h); // the true residual, free of the recurrence's drift
                history.back() = largest(r) / light;
                if (!(history.back() <= options.tolerance)) {
                    if (iterations >= options.max_iterations) {
                        reason = SolveSummary::Reason::max_iterations;
                        return;
                    }
                    if (!(history.back() < 0.999 * before)) {
                        reason = SolveSummary::Reason::stagnated;
                        return;
                    }
                }
            }
        }

        /// One cycle from residual r: h += V y with y minimising ‖r - A V y‖₂.
        void cycle(long restart, double light, Vector r) {
            const double beta = r.norm();
            std::vector<Vector> V{r / beta};
            std::vector<Vector> R; // columns of the triangular factor
            std::vector<double> cosine, sine, g{beta};
            for (long k = 0; k < restart && iterations < options.max_iterations; ++k) {
                Vector w = A(V.back());
                ++iterations;
                Vector column = Vector::Zero(k + 2);
                for (int pass = 0; pass < 2; ++pass) {
                    for (long i = 0; i <= k; ++i) {
                        const double overlap = V[static_cast<std::size_t>(i)].dot(w);
                        column[i] += overlap;
                        w -= overlap * V[static_cast<std::size_t>(i)];
                    }
                }
                const double rest = w.norm();
                column[k + 1] = rest;
                for (long i = 0; i < k; ++i) { // earlier rotations
                    const auto s = static_cast<std::size_t>(i);
                    const double upper = cosine[s] * column[i] + sine[s] * column[i + 1];
                    column[i + 1] = -sine[s] * column[i] + cosine[s] * column[i + 1];
                    column[i] = upper;
                }
                const double length = std::hypot(column[k], column[k + 1]);
                if (length == 0.0) {
                    break; // A is singular on this space: nothing to gain
                }
                const double cos_k = column[k] / length, sin_k = column[k + 1] / length;
                cosine.push_back(cos_k);
                sine.push_back(sin_k);
                column[k] = length;
                R.push_back(column.head(k + 1));
                g.push_back(-sin_k * g.back());
                g[static_cast<std::size_t>(k)] *= cos_k;
                if (rest > 0.0) {
                    V.push_back(w / rest);
                    // r_k = s_k² r_{k-1} + c_k g_{k+1} v_{k+1} (Saad, "Iterative Methods", 6.5.3)
                    r = sin_k * sin_k * r + cos_k * g.back() * V.back();
                } else {
                    r.setZero();
                }
                history.push_back(largest(r) / light);
                if (history.back() <= 0.5 * options.tolerance || rest == 0.0) {
                    break;
                }
            }
            std::vector<double> y(R.size()); // back substitution: R y = g
            for (std::size_t k = R.size(); k-- > 0;) {
                y[k] = g[k];
                for (std::size_t j = k + 1; j < R.size(); ++j) {
                    y[k] -= R[j][static_cast<Eigen::Index>(k)] * y[j];
                }
                y[k] /= R[k][static_cast<Eigen::Index>(k)];
            }
            for (std::size_t k = 0; k < R.size(); ++k) {
                h += y[k] * V[k];
            }
        }
    };

    long restart_;
};

} // namespace

DIFUSA_PLUGIN(solver, "krylov", Krylov, "Restarted GMRES: few iterations at high reflectance.",
              {{"restart",
                difusa::ParameterSpec::Type::integer,
                "50",
                "iterations before the space is started anew",
                2,
                1000,
                {}}})
