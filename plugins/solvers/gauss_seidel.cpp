// Solver `gauss-seidel` (L 61, 69): relaxes one unknown after the other, in the order of the points, with the newest
// values of all others. A sweep over all unknowns is one iteration; starts with h = g.
//   relaxation  omega of successive over-relaxation (Young 1950; L 48, 65), 1: an unknown becomes omega times its new
//               value less (omega - 1) times its old one; the lectures' 110 % less 10 % are 1.1
//
// Row j of T = D diag(rho) P Π is not stored: that would take n² entries for each channel. Instead the reflected
// radiosity of the surfels, b = diag(rho) P Π h, follows every change of h: with b at hand, (T h)_j is the product of
// row j of D with b, and a change of h_j adds a multiple of column j of diag(rho) P Π to b. A sweep costs as many
// multiplications as a product with T. Rows of D are read once for all channels and sets of lights, unless there are as
// many threads as those. A projection that solves a system has no such columns, and is refused.
//
// The residual of an unknown is known when its turn comes, and not that of all at one time: the history holds, for each
// sweep, the largest residual met, and the first and last entries are residuals of the whole equation.
#include <difusa/algebra/factors.h>
#include <difusa/algebra/solver.h>
#include <difusa/core/parallel.h>
#include <difusa/plugin/plugin.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace {

using difusa::Index;
using difusa::SolveSummary;
using difusa::Values;

/// One call of `solve`.
class Sweeps {
  public:
    Sweeps(const difusa::SolveProblem& problem, const difusa::SolveOptions& options, double relaxation,
           const difusa::Execution& execution)
        : problem_(problem), options_(options), execution_(execution), relaxation_(relaxation),
          factors_(difusa::factors_for("gauss-seidel", *problem.T, execution)), rows_(*factors_->A),
          diagonal_(factors_->diagonal(execution)), showing_(options), columns_(problem.g.cols()),
          light_(static_cast<std::size_t>(columns_)), met_(light_), changed_(light_) {
        summary_.h = problem.g;
        summary_.residual_history.resize(light_.size());
        for (Eigen::Index c = 0; c < columns_; ++c) {
            light_[at(c)] = problem.g.col(c).cwiseAbs().maxCoeff<Eigen::PropagateNaN>();
        }
        summary_.entries_touched = static_cast<std::size_t>(columns_) * entries_of_sweep(); // of the diagonal
    }

    SolveSummary solve() {
        measure();
        for (const double residual : met_) {
            summary_.residual = difusa::larger(summary_.residual, residual);
        }
        const double first = summary_.residual;
        push();
        show();
        if (confirmed()) {
            return end(SolveSummary::Reason::converged);
        }
        reflect();
        for (;;) {
            execution_.check();
            if (!std::isfinite(summary_.residual) || summary_.residual > 1e6 * std::max(first, 1.0)) {
                return end(SolveSummary::Reason::diverged);
            }
            if (summary_.iterations == options_.max_iterations) {
                return end(SolveSummary::Reason::max_iterations);
            }
            sweep();
            ++summary_.iterations;
            push();
            if (claims()) {
                measure(); // without the rounding errors of all the changes of b
                if (by_change() || confirmed()) {
                    return end(SolveSummary::Reason::converged);
                }
                reflect();
            }
            if (showing_.is_due(relaxations())) {
                show();
            }
        }
    }

  private:
    static std::size_t at(Eigen::Index c) { return static_cast<std::size_t>(c); }
    bool by_change() const { return options_.stop == difusa::StopBy::change; }
    std::size_t entries_of_sweep() const { return factors_->A->entry_count() + factors_->Q.row.size(); }
    std::size_t relaxations() const {
        return static_cast<std::size_t>(summary_.iterations) * static_cast<std::size_t>(summary_.h.rows());
    }

    /// The relative residuals of the equation, into `met_`.
    void measure() {
        met_ = difusa::relative_residual(problem_, summary_.h, residual_, execution_);
        summary_.entries_touched += static_cast<std::size_t>(columns_) * problem_.T->entry_count();
    }

    /// Whether the residuals measured suffice.
    bool confirmed() const {
        for (Eigen::Index c = 0; c < columns_; ++c) {
            const bool enough = !by_change() && met_[at(c)] <= options_.tolerance;
            if (!enough && !difusa::is_rounding(residual_.col(c).cwiseAbs().maxCoeff<Eigen::PropagateNaN>(),
                                                summary_.h.col(c).cwiseAbs().maxCoeff())) {
                return false;
            }
        }
        return true;
    }

    /// Whether what the sweep met promises that the residuals suffice.
    bool claims() const {
        for (Eigen::Index c = 0; c < columns_; ++c) {
            const double size = by_change() ? changed_[at(c)] : met_[at(c)];
            if (!(size <= options_.tolerance) &&
                !difusa::is_rounding(size * light_[at(c)], summary_.h.col(c).cwiseAbs().maxCoeff())) {
                return false;
            }
        }
        return true;
    }

    void push() {
        summary_.residual = met_.front();
        for (std::size_t c = 0; c < met_.size(); ++c) {
            summary_.residual_history[c].push_back(met_[c]);
            summary_.residual = difusa::larger(summary_.residual, met_[c]);
        }
    }

    void show() { showing_.show({relaxations(), summary_.entries_touched, summary_.residual, summary_.h}); }

    SolveSummary end(SolveSummary::Reason reason) {
        measure();
        for (std::size_t c = 0; c < met_.size(); ++c) {
            summary_.residual_history[c].pop_back();
        }
        push();
        if (by_change() && summary_.iterations > 0) {
            summary_.change = *std::max_element(changed_.begin(), changed_.end());
        }
        summary_.reason = reason;
        show();
        return difusa::judged(std::move(summary_), options_);
    }

    /// `body(first, count)` for the columns of each thread.
    template <class Body> void for_columns(const Body& body) const {
        const auto count = static_cast<std::size_t>(columns_),
                   threads = std::min<std::size_t>(count, execution_.threads);
        difusa::parallel_for(count, (count + threads - 1) / threads, difusa::Unreported(execution_),
                             [&](std::size_t begin, std::size_t last, unsigned) {
                                 body(static_cast<Eigen::Index>(begin), static_cast<Eigen::Index>(last - begin));
                             });
    }

    /// b += column j of diag(rho) P Π times the changes of h_j.
    void add(Index j, Eigen::Index first, Eigen::Index count, const double* change) {
        const difusa::SparseColumns& Q = factors_->Q;
        const Eigen::Index channels = factors_->channels();
        for (std::size_t e = Q.first[j]; e < Q.first[j + 1]; ++e) {
            double* const to = b_.data() + static_cast<Eigen::Index>(Q.row[e]) * columns_ + first;
            for (Eigen::Index c = 0; c < count; ++c) {
                to[c] += Q.value(static_cast<Eigen::Index>(e), (first + c) % channels) * change[c];
            }
        }
    }

    /// b = diag(rho) P Π h
    void reflect() {
        b_ = Values::Zero(static_cast<Eigen::Index>(factors_->middle), columns_);
        for_columns([&](Eigen::Index first, Eigen::Index count) {
            for (Index j = 0; j < factors_->size(); ++j) {
                add(j, first, count, summary_.h.data() + static_cast<Eigen::Index>(j) * columns_ + first);
            }
        });
        summary_.entries_touched += static_cast<std::size_t>(columns_) * factors_->Q.row.size();
    }

    /// Relaxes all unknowns; the largest relative residuals met into `met_`, the largest changes into `changed_`.
    void sweep() {
        std::fill(met_.begin(), met_.end(), 0.0);
        std::fill(changed_.begin(), changed_.end(), 0.0);
        const Eigen::Index channels = factors_->channels();
        for_columns([&](Eigen::Index first, Eigen::Index count) {
            std::vector<Index> surfels;
            std::vector<double> weights, sum(static_cast<std::size_t>(count));
            for (Index j = 0; j < factors_->size(); ++j) {
                rows_.row(j, surfels, weights);
                std::fill(sum.begin(), sum.end(), 0.0);
                for (std::size_t k = 0; k < surfels.size() && surfels[k] < factors_->middle; ++k) {
                    const double* const b = b_.data() + static_cast<Eigen::Index>(surfels[k]) * columns_ + first;
                    for (std::size_t c = 0; c < sum.size(); ++c) {
                        sum[c] += weights[k] * b[c];
                    }
                }
                for (Eigen::Index c = 0; c < count; ++c) {
                    const double light = light_[at(first + c)];
                    double& h = summary_.h(j, first + c);
                    const double r = problem_.g(j, first + c) + sum[at(c)] - h;
                    const double change = relaxation_ * r / (1.0 - diagonal_(j, (first + c) % channels));
                    h += change;
                    sum[at(c)] = change;
                    if (light != 0.0) {
                        double &met = met_[at(first + c)], &changed = changed_[at(first + c)];
                        met = difusa::larger(met, std::abs(r) / light);
                        changed = difusa::larger(changed, std::abs(change) / light);
                    }
                }
                add(j, first, count, sum.data());
            }
        });
        summary_.entries_touched += static_cast<std::size_t>(columns_) * entries_of_sweep();
    }

    const difusa::SolveProblem& problem_;
    const difusa::SolveOptions& options_;
    const difusa::Execution& execution_;
    double relaxation_;
    std::shared_ptr<const difusa::Factors> factors_;
    difusa::RowReader rows_;
    Values diagonal_; ///< of T
    difusa::Showing showing_;
    Eigen::Index columns_;
    std::vector<double> light_, met_, changed_; ///< of each column
    Values b_, residual_;
    SolveSummary summary_;
};

class GaussSeidel final : public difusa::Solver {
  public:
    explicit GaussSeidel(const difusa::Parameters& parameters) : relaxation_(parameters.real("relaxation")) {}

    bool needs_factors() const override { return true; }

    SolveSummary solve(const difusa::SolveProblem& problem, const difusa::SolveOptions& options,
                       const difusa::Execution& execution) const override {
        return Sweeps(problem, options, relaxation_, execution).solve();
    }

  private:
    double relaxation_;
};

} // namespace

DIFUSA_PLUGIN(solver, "gauss-seidel", GaussSeidel, "Sweeps that use new values at once (L 61), with over-relaxation.",
              {{"relaxation",
                difusa::ParameterSpec::Type::real,
                "1",
                "omega: 1.1 is the lectures' 110 % less 10 %",
                0.05,
                1.95,
                {}}})
