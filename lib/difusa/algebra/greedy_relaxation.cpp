#include <difusa/algebra/greedy_relaxation.h>

#include <difusa/core/parallel.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace difusa {

namespace {

/// Steps between looks at whether the computation was cancelled.
constexpr std::size_t steps_of_look = 256;
/// A residual that has grown by this factor will not shrink again.
constexpr double hopeless_growth = 1e6;
/// An unknown that makes the surface reflect next to nothing is shot as if it were this share of an average one: its
/// residual is to fall below the tolerance, too.
constexpr double least_power = 1e-3;
/// Claims that are not confirmed make the next one stricter; below this share of the tolerance there will be none.
constexpr double strictest_claim = 1e-3;

/// What all columns share.
struct GreedyTransport {
    std::shared_ptr<const Factors> factors;
    SparseColumns A;
    Values diagonal; ///< of T

    GreedyTransport(const char* solver, const LinearOperator& T, const Execution& execution)
        : factors(factors_for(solver, T, execution)), A(factors->columns_of_A(execution)),
          diagonal(factors->diagonal(execution)) {}

    std::size_t entries() const { return A.row.size() + factors->Q.row.size(); }
};

/// The first unknown whose weighted residual is largest, and the largest residual.
struct GreedyChoice {
    double weighted = 0.0, largest = 0.0;
    Index next = none;

    bool operator==(const GreedyChoice&) const = default;

    /// Of these unknowns and of others that come after them.
    GreedyChoice with(const GreedyChoice& later) const {
        const GreedyChoice& first = later.weighted > weighted ? later : *this;
        return {first.weighted, std::max(largest, later.largest), first.next};
    }
};

/// The choice among all unknowns, by a tournament: after a step that changes few residuals, few matches are played
/// again.
class GreedyTournament {
  public:
    explicit GreedyTournament(Eigen::VectorXd weight)
        : weight_(std::move(weight)), leaves_(std::bit_ceil(static_cast<std::size_t>(weight_.size()))) {}

    /// All residuals may have changed.
    void forget() { known_ = false; }

    /// Begins a step that has changed so many residuals, at most. True if `change` is to be called for each of them.
    bool is_worthwhile(std::size_t changed) {
        few_ = changed < static_cast<std::size_t>(weight_.size()) / 8;
        known_ = known_ && few_;
        return known_;
    }

    void change(const Eigen::VectorXd& r, Index i) {
        std::size_t node = leaves_ + i;
        GreedyChoice now = of(r, static_cast<Eigen::Index>(i));
        while (!(nodes_[node] == now)) {
            nodes_[node] = now;
            if (node == 1) {
                break;
            }
            node /= 2;
            now = nodes_[2 * node].with(nodes_[2 * node + 1]);
        }
    }

    GreedyChoice choose(const Eigen::VectorXd& r) {
        if (!known_ && !few_) {
            GreedyChoice choice; // as if by `with`
            for (Eigen::Index i = 0; i < r.size(); ++i) {
                const double size = std::abs(r[i]), weighted = weight_[i] * size;
                choice.largest = std::max(choice.largest, size);
                if (weighted > choice.weighted) {
                    choice.weighted = weighted;
                    choice.next = static_cast<Index>(i);
                }
            }
            return choice;
        }
        if (!known_) {
            nodes_.assign(2 * leaves_, {});
            for (Eigen::Index i = 0; i < r.size(); ++i) {
                nodes_[leaves_ + static_cast<std::size_t>(i)] = of(r, i);
            }
            for (std::size_t node = leaves_; node-- > 1;) {
                nodes_[node] = nodes_[2 * node].with(nodes_[2 * node + 1]);
            }
            known_ = true;
        }
        return nodes_[1];
    }

  private:
    /// NaN is never chosen.
    GreedyChoice of(const Eigen::VectorXd& r, Eigen::Index i) const {
        const double size = std::abs(r[i]), weighted = weight_[i] * size;
        return weighted > 0.0 ? GreedyChoice{weighted, std::max(0.0, size), static_cast<Index>(i)}
                              : GreedyChoice{0.0, std::max(0.0, size), none};
    }

    Eigen::VectorXd weight_;
    std::size_t leaves_;
    std::vector<GreedyChoice>
        nodes_;          ///< 1: of all; 2 k and 2 k + 1: the halves of k; from `leaves_` on: of each unknown
    bool known_ = false; ///< whether they are those of the residuals
    bool few_ = false;   ///< whether the last step changed few residuals
};

/// The equation of one column, step by step.
class GreedyColumn {
  public:
    /// `r`: the residual of x.
    GreedyColumn(const GreedyTransport& transport, const GreedyRule& rule, const SolveOptions& options,
                 Eigen::Index channel, Eigen::VectorXd g, Eigen::VectorXd x, Eigen::VectorXd r)
        : transport_(transport), rule_(rule), options_(options), channel_(channel), g_(std::move(g)), x_(std::move(x)),
          r_(std::move(r)), choice_(weights(transport, rule, channel)),
          light_(g_.cwiseAbs().maxCoeff<Eigen::PropagateNaN>()) {
        first_ = relative(r_);
        history_.push_back(first_);
        before_ = shown(false);
        if (light_ == 0.0) {
            done_ = true;
        } else if (!std::isfinite(first_)) {
            end(SolveSummary::Reason::diverged);
        }
    }

    bool done() const { return done_; }
    bool claims() const { return claims_; }
    std::size_t steps() const { return steps_; }
    std::size_t entries() const { return entries_; }
    SolveSummary::Reason reason() const { return reason_; }
    std::vector<double>& history() { return history_; }
    const std::vector<double>& history() const { return history_; }
    const Eigen::VectorXd& g() const { return g_; }
    const Eigen::VectorXd& x() const { return x_; }
    double residual() const { return relative(r_); }
    double change() const { return change_; }
    int iterations() const { return static_cast<int>((steps_ + size() - 1) / size()); }

    /// The result, or what is displayed on the way to it.
    Eigen::VectorXd shown(bool ambient) const {
        if (!rule_.shooting) {
            return x_;
        }
        Eigen::VectorXd h = x_ + r_;
        const Eigen::VectorXd power = transport_.factors->power.col(channel_);
        const double area = transport_.factors->area, rho = power.sum() / area;
        if (ambient && rule_.ambient && rho < 1.0) {
            h.array() += power.dot(r_) / area / (1.0 - rho);
        }
        return h;
    }

    /// Relaxes until there were `target` steps in all, or no residual is above the tolerance.
    void advance(std::size_t target, const Execution& execution) {
        const double wanted = options_.stop == StopBy::residual ? options_.tolerance * light_ : 0.0;
        const double limit =
            strictness_ * std::max(wanted, rounding_of_residual * x_.cwiseAbs().maxCoeff<Eigen::PropagateNaN>());
        while (!done_ && !claims_) {
            if (steps_ % steps_of_look == 0) {
                execution.check();
            }
            const GreedyChoice choice = choice_.choose(r_);
            if (choice.largest <= limit || choice.next == none) {
                claims_ = true;
            } else if (steps_ == target) {
                return;
            } else {
                relax(choice.next);
            }
        }
    }

    /// After a whole iteration.
    void close_iteration() {
        const double now = relative(r_);
        history_.push_back(now);
        if (options_.stop == StopBy::change) {
            Eigen::VectorXd h = shown(false);
            change_ = relative(h - before_);
            before_ = std::move(h);
        }
        if (!std::isfinite(now) || now > hopeless_growth * std::max(first_, 1.0)) {
            end(SolveSummary::Reason::diverged);
        } else if (options_.stop == StopBy::change && change_ <= options_.tolerance) {
            end(SolveSummary::Reason::converged);
        }
    }

    /// Judges a claim by residuals computed afresh, free of the rounding errors of all the steps: `r` of x, `of_result`
    /// of the result.
    void verify(Eigen::VectorXd r, const Eigen::VectorXd& of_result) {
        claims_ = false;
        r_ = std::move(r);
        choice_.forget();
        strictness_ *= 0.5;
        const double now = relative(of_result);
        if ((options_.stop == StopBy::residual && now <= options_.tolerance) ||
            is_rounding(of_result.cwiseAbs().maxCoeff<Eigen::PropagateNaN>(), x_.cwiseAbs().maxCoeff())) {
            end(SolveSummary::Reason::converged);
        } else if (!std::isfinite(now)) {
            end(SolveSummary::Reason::diverged);
        } else if (strictness_ < strictest_claim) {
            end(SolveSummary::Reason::stagnated);
        }
    }

    void end(SolveSummary::Reason reason) {
        done_ = true;
        reason_ = reason;
        if (history_.size() < static_cast<std::size_t>(iterations()) + 1) { // an iteration was begun
            history_.push_back(relative(r_));
        }
    }

  private:
    std::size_t size() const { return static_cast<std::size_t>(g_.size()); }
    double relative(const Eigen::VectorXd& r) const {
        return light_ == 0.0 ? 0.0 : r.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() / light_;
    }

    /// What the residual of each unknown counts.
    static Eigen::VectorXd weights(const GreedyTransport& transport, const GreedyRule& rule, Eigen::Index channel) {
        const Eigen::VectorXd power = transport.factors->power.col(channel).cwiseAbs();
        const double mean = rule.shooting ? power.mean() : 0.0;
        return mean > 0.0 ? Eigen::VectorXd(power.cwiseMax(least_power * mean))
                          : Eigen::VectorXd(Eigen::VectorXd::Ones(power.size()));
    }

    void relax(Index i) {
        const double delta = rule_.relaxation * r_[i] / (1.0 - transport_.diagonal(i, channel_));
        const SparseColumns &Q = transport_.factors->Q, &A = transport_.A;
        std::size_t touched = 1;
        for (std::size_t e = Q.first[i]; e < Q.first[i + 1]; ++e) {
            const double through = delta * Q.value(static_cast<Eigen::Index>(e), channel_);
            const Index s = Q.row[e];
            for (std::size_t a = A.first[s]; a < A.first[s + 1]; ++a) {
                r_[A.row[a]] += through * A.value(static_cast<Eigen::Index>(a), 0);
            }
            touched += A.first[s + 1] - A.first[s];
            entries_ += A.first[s + 1] - A.first[s] + 1;
        }
        r_[i] -= delta;
        x_[i] += delta;
        ++steps_;
        if (!choice_.is_worthwhile(touched)) {
            return;
        }
        choice_.change(r_, i);
        for (std::size_t e = Q.first[i]; e < Q.first[i + 1]; ++e) {
            for (std::size_t a = A.first[Q.row[e]]; a < A.first[Q.row[e] + 1]; ++a) {
                choice_.change(r_, A.row[a]);
            }
        }
    }

    const GreedyTransport& transport_;
    const GreedyRule& rule_;
    const SolveOptions& options_;
    Eigen::Index channel_;
    Eigen::VectorXd g_, x_, r_, before_; ///< before_: the result after the last whole iteration
    GreedyTournament choice_;
    double light_, first_ = 0.0, change_ = 0.0;
    double strictness_ = 1.0; ///< share of the tolerance at which convergence is claimed
    std::vector<double> history_;
    std::size_t steps_ = 0, entries_ = 0;
    bool done_ = false, claims_ = false;
    SolveSummary::Reason reason_ = SolveSummary::Reason::converged;
};

/// One call of `relax_greedily`.
class GreedyRun {
  public:
    GreedyRun(const SolveProblem& problem, const SolveOptions& options, const GreedyRule& rule,
              const Execution& execution)
        : problem_(problem), options_(options), execution_(execution), transport_(rule.solver, *problem.T, execution),
          showing_(options), n_(static_cast<std::size_t>(problem.g.rows())), shooting_(rule.shooting) {
        Values x = rule.shooting ? Values::Zero(problem.g.rows(), problem.g.cols()) : problem.g, r = problem.g;
        if (!rule.shooting) {
            relative_residual(problem, x, r, execution);
            products_ = 1;
        }
        for (Eigen::Index c = 0; c < x.cols(); ++c) {
            columns_.emplace_back(transport_, rule, options, c % transport_.factors->channels(), problem.g.col(c),
                                  x.col(c), r.col(c));
        }
    }

    SolveSummary solve() {
        const std::size_t last = n_ * static_cast<std::size_t>(options_.max_iterations);
        std::size_t steps = 0;
        show(steps);
        while (!all_done()) {
            if (steps >= last) {
                for (GreedyColumn& column : columns_) {
                    if (!column.done()) {
                        column.end(SolveSummary::Reason::max_iterations);
                    }
                }
                break;
            }
            const std::size_t boundary = (steps / n_ + 1) * n_;
            steps = showing_.wanted() ? std::clamp(showing_.next(), steps + 1, boundary) : boundary;
            advance(steps);
            for (GreedyColumn& column : columns_) {
                if (steps == boundary && !column.done()) {
                    column.close_iteration();
                }
            }
            if (!all_done() && showing_.is_due(steps)) { // otherwise the summary shows the last
                show(steps);
            }
        }
        return summary();
    }

  private:
    bool all_done() const {
        return std::all_of(columns_.begin(), columns_.end(), [](const GreedyColumn& column) { return column.done(); });
    }

    void advance(std::size_t target) {
        for (bool claimed = true; claimed;) {
            parallel_for(columns_.size(), 1, Unreported(execution_), [&](std::size_t begin, std::size_t end, unsigned) {
                for (std::size_t c = begin; c < end; ++c) {
                    columns_[c].advance(target, execution_);
                }
            });
            claimed = std::any_of(columns_.begin(), columns_.end(),
                                  [](const GreedyColumn& column) { return !column.done() && column.claims(); });
            if (claimed) {
                verify();
            }
        }
    }

    void verify() {
        execution_.check();
        Values x(problem_.g.rows(), problem_.g.cols()), r;
        for (std::size_t c = 0; c < columns_.size(); ++c) {
            x.col(static_cast<Eigen::Index>(c)) = columns_[c].x();
        }
        relative_residual(problem_, x, r, execution_);
        ++products_;
        Values of_result = r;
        if (shooting_) {
            relative_residual(problem_, x + r, of_result, execution_);
            ++products_;
        }
        for (std::size_t c = 0; c < columns_.size(); ++c) {
            if (!columns_[c].done() && columns_[c].claims()) {
                const auto column = static_cast<Eigen::Index>(c);
                columns_[c].verify(r.col(column), of_result.col(column));
            }
        }
    }

    Values shown(bool ambient) const {
        Values h(problem_.g.rows(), problem_.g.cols());
        for (std::size_t c = 0; c < columns_.size(); ++c) {
            h.col(static_cast<Eigen::Index>(c)) = columns_[c].shown(ambient);
        }
        return h;
    }

    std::size_t entries() const {
        const std::size_t products = products_ * columns_.size() * problem_.T->entry_count();
        std::size_t sum = products + columns_.size() * transport_.entries(); // ... and the diagonal
        for (const GreedyColumn& column : columns_) {
            sum += column.entries();
        }
        return sum;
    }

    void show(std::size_t steps) {
        if (showing_.wanted()) {
            double residual = 0.0;
            for (const GreedyColumn& column : columns_) {
                residual = larger(residual, column.residual());
            }
            showing_.show({steps, entries(), residual, shown(true)});
        }
    }

    SolveSummary summary() {
        execution_.check();
        SolveSummary summary;
        summary.h = shown(false);
        Values r;
        const std::vector<double> residual = relative_residual(problem_, summary.h, r, execution_);
        ++products_;
        std::size_t steps = 0;
        for (std::size_t c = 0; c < columns_.size(); ++c) {
            GreedyColumn& column = columns_[c];
            column.history().back() = residual[c];
            summary.residual = larger(summary.residual, residual[c]);
            summary.iterations = std::max(summary.iterations, column.iterations());
            steps = std::max(steps, column.steps());
            if (options_.stop == StopBy::change) {
                summary.change = larger(summary.change.value_or(0.0), column.change());
            }
            if (column.reason() != SolveSummary::Reason::converged) {
                summary.reason = column.reason();
            }
            summary.residual_history.push_back(std::move(column.history()));
        }
        summary.entries_touched = entries();
        showing_.show({steps, summary.entries_touched, summary.residual, summary.h});
        return judged(std::move(summary), options_);
    }

    const SolveProblem& problem_;
    const SolveOptions& options_;
    const Execution& execution_;
    GreedyTransport transport_;
    Showing showing_;
    std::size_t n_;
    bool shooting_;
    std::vector<GreedyColumn> columns_;
    std::size_t products_ = 0; ///< with all columns
};

} // namespace

SolveSummary relax_greedily(const SolveProblem& problem, const SolveOptions& options, const GreedyRule& rule,
                            const Execution& execution) {
    return GreedyRun(problem, options, rule, execution).solve();
}

} // namespace difusa
