// Solver `krylov`: restarted GMRES (Saad and Schultz 1986) on A h = g, A = I - T. Each column has its own Krylov space;
// all unfinished columns advance together, so that T is read once for all of them. The residual never grows, and far
// fewer applications of T are needed than by `jacobi` if the reflectance is near 1. Spaces may be built with products
// of operands in single precision (LinearOperator::prefers_single; Simoncini and Szyld 2003), also of few columns, so
// that the bits of one do not depend on others: what ends the iteration is the true residual, with exact products,
// which also begins another space if there is more to correct.
#include <difusa/algebra/solver.h>
#include <difusa/algebra/vector_blocks.h>
#include <difusa/core/parallel.h>
#include <difusa/plugin/plugin.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace {

using difusa::SolveSummary;
using difusa::Values;
using Vector = Eigen::VectorXd;

/// Residuals that are smaller than this, relative to those that a space begins with, tell of rounding if its operands
/// have single precision.
constexpr double least_of_single = 0x1p-22;

/// The largest absolute entry; NaN if there is one.
double largest(const Vector& x) {
    return x.cwiseAbs().maxCoeff<Eigen::PropagateNaN>();
}

double largest_or_one(const Vector& x) {
    const double size = largest(x);
    return size > 0.0 && std::isfinite(size) ? size : 1.0;
}

/// The basis V of one Krylov space and the minimisation of ‖r - A V y‖₂ by Givens rotations.
class Space {
  public:
    Space(const Vector& r, const difusa::Execution& execution) : residual_(r), execution_(execution) {
        beta_ = difusa::norm(r, execution);
        V_.push_back(r / beta_);
        g_.push_back(beta_);
    }

    /// The norm of the residual, over that of r.
    double reduction() const { return std::abs(g_.back()) / beta_; }

    const Vector& newest() const { return V_.back(); }
    const Vector& residual() const { return residual_; } ///< r - A V y for the minimising y
    std::size_t size() const { return R_.size(); }

    /// Extends the space by w = A newest(). False if continuing gains nothing.
    bool extend(Vector w) {
        const auto k = static_cast<Eigen::Index>(V_.size()) - 1;
        Vector column(k + 2);
        column.head(k + 1) = difusa::orthogonalise(V_, w, execution_);
        const double rest = difusa::norm(w, execution_);
        column[k + 1] = rest;
        for (Eigen::Index i = 0; i < k; ++i) { // earlier rotations
            const auto s = static_cast<std::size_t>(i);
            const double upper = cosine_[s] * column[i] + sine_[s] * column[i + 1];
            column[i + 1] = -sine_[s] * column[i] + cosine_[s] * column[i + 1];
            column[i] = upper;
        }
        const double length = std::hypot(column[k], column[k + 1]);
        if (length == 0.0) {
            return false; // A is singular on this space
        }
        const double cos_k = column[k] / length, sin_k = column[k + 1] / length;
        cosine_.push_back(cos_k);
        sine_.push_back(sin_k);
        column[k] = length;
        R_.emplace_back(column.head(k + 1));
        g_.push_back(-sin_k * g_.back());
        g_[static_cast<std::size_t>(k)] *= cos_k;
        if (rest > 0.0) {
            w /= rest;
            V_.push_back(std::move(w));
            // r_k = s_k² r_{k-1} + c_k g_{k+1} v_{k+1} (Saad, "Iterative Methods", 6.5.3)
            difusa::for_blocks(residual_.size(), execution_, [&](Eigen::Index first, Eigen::Index count, Eigen::Index) {
                residual_.segment(first, count) = sin_k * sin_k * residual_.segment(first, count) +
                                                  cos_k * g_.back() * V_.back().segment(first, count);
            });
        } else {
            residual_.setZero();
        }
        return rest > 0.0;
    }

    /// h += V y
    void add_to(Vector& h) const {
        std::vector<double> y(R_.size()); // back substitution: R y = g
        for (std::size_t k = R_.size(); k-- > 0;) {
            y[k] = g_[k];
            for (std::size_t j = k + 1; j < R_.size(); ++j) {
                y[k] -= R_[j][static_cast<Eigen::Index>(k)] * y[j];
            }
            y[k] /= R_[k][static_cast<Eigen::Index>(k)];
        }
        difusa::for_blocks(h.size(), execution_, [&](Eigen::Index first, Eigen::Index count, Eigen::Index) {
            for (std::size_t k = 0; k < R_.size(); ++k) {
                h.segment(first, count) += y[k] * V_[k].segment(first, count);
            }
        });
    }

  private:
    std::vector<Vector> V_, R_; ///< basis; columns of the triangular factor
    std::vector<double> cosine_, sine_, g_;
    double beta_ = 0.0; ///< norm of r
    Vector residual_;
    const difusa::Execution& execution_;
};

/// The solution of one column, step by step: `operand()` gives the next vector to apply A to, `take` receives the
/// result.
class Column {
  public:
    Column(Vector g, const difusa::SolveOptions& options, std::size_t restart, const difusa::Execution& execution)
        : g_(std::move(g)), h_(g_), before_(g_), light_(largest(g_)), options_(options), restart_(restart),
          execution_(execution) {
        // Starts from g: better than zero, and its residual is the first bounce.
        if (light_ == 0.0) {
            history_.push_back(0.0);
            done_ = true;
        }
    }

    bool done() const { return done_; }
    /// Whether the true residual is to be found next.
    bool awaits_residual() const { return !done_ && space_.empty(); }
    const Vector& operand() const { return space_.empty() ? h_ : space_.front().newest(); }
    const Vector& h() const { return h_; }
    const std::vector<double>& history() const { return history_; }
    int iterations() const { return iterations_; }
    SolveSummary::Reason reason() const { return reason_; }

    /// The best solution so far.
    Vector estimate() const {
        Vector h = h_;
        if (!space_.empty()) {
            space_.front().add_to(h);
        }
        return h;
    }
    double change() const { return change_; } ///< by the last iteration, relative; if it is to stop the iteration

    /// `rounded`: the operand had single precision.
    void take(Vector A_operand, bool rounded) {
        if (space_.empty()) {
            restart(g_ - A_operand, rounded); // the true residual, free of the recurrence's drift
            return;
        }
        ++iterations_;
        Space& space = space_.front();
        const std::size_t before = space.size();
        const bool more = space.extend(std::move(A_operand));
        if (space.size() > before) {
            history_.push_back(largest(space.residual()) / light_);
        }
        bool enough = history_.back() <= 0.5 * options_.tolerance;
        if (options_.stop == difusa::StopBy::change) {
            Vector h = estimate();
            change_ = largest(h - before_) / light_;
            before_ = std::move(h);
            enough = change_ <= options_.tolerance;
        }
        const bool exhausted = rounded && space.reduction() <= least_of_single;
        if (!more || enough || exhausted || space.size() >= restart_ || iterations_ >= options_.max_iterations) {
            space.add_to(h_);
            space_.clear();
            done_ = enough && !options_.confirm;
        }
    }

  private:
    /// From the true residual of h: done, stalled, or a new space.
    void restart(const Vector& r, bool rounded) {
        const double now = largest(r) / light_;
        const bool first = history_.empty();
        if (first) {
            history_.push_back(now);
        } else {
            history_.back() = now;
        }
        using Reason = SolveSummary::Reason;
        done_ = true;
        const bool enough = options_.stop == difusa::StopBy::residual ? now <= options_.tolerance
                                                                      : !first && change_ <= options_.tolerance;
        if (rounded && (enough || difusa::is_rounding(largest(r), largest(h_)))) {
            done_ = false; // an exact residual is to confirm it
        } else if (enough || difusa::is_rounding(largest(r), largest(h_))) {
            reason_ = Reason::converged;
        } else if (!std::isfinite(now)) {
            reason_ = Reason::diverged;
        } else if (iterations_ >= options_.max_iterations) {
            reason_ = Reason::max_iterations;
        } else if (!(now < 0.999 * last_true_)) {
            reason_ = Reason::stagnated;
        } else {
            done_ = false;
            last_true_ = now;
            space_.emplace_back(r, execution_);
        }
    }

    Vector g_, h_, before_; ///< before_: the estimate after the last iteration, if its change is to stop them
    double light_, change_ = 0.0;
    const difusa::SolveOptions& options_;
    std::size_t restart_;
    const difusa::Execution& execution_;
    std::vector<Space> space_; ///< empty while the true residual is pending, otherwise one
    std::vector<double> history_;
    double last_true_ = std::numeric_limits<double>::infinity();
    int iterations_ = 0;
    SolveSummary::Reason reason_ = SolveSummary::Reason::converged;
    bool done_ = false;
};

/// Advances columns together: applies A to the operands of several with one product.
class Products {
  public:
    /// `by_column`: how columns are handled side by side. Keeps references.
    Products(const difusa::SolveProblem& problem, std::vector<Column>& columns, const difusa::Execution& by_column,
             const difusa::Execution& execution)
        : problem_(problem), columns_(columns), by_column_(by_column), execution_(execution), Ax_(columns.size()),
          unit_(columns.size(), 1.0) {}

    /// Of those columns that take part, and with operands in single precision if these are `rounded`. Returns how many
    /// matrix entries were multiplied.
    template <class TakesPart> std::size_t advance(const TakesPart& takes_part, bool rounded) {
        choose(takes_part);
        for_each([&](std::size_t c) { // constant operands stay exact
            unit_[c] = rounded ? largest_or_one(columns_[c].operand()) : 1.0;
            Ax_[c].resize(problem_.g.rows());
        });
        if (rounded) {
            multiply(x_single_);
        } else {
            multiply(x_);
        }
        for_rows([&](std::size_t c, Eigen::Index at, const auto& rows) {
            Ax_[c](rows) = columns_[c].operand()(rows) - unit_[c] * Tx_(rows, at);
        });
        for_each([&](std::size_t c) {
            if (takes_part(columns_[c])) {
                columns_[c].take(std::move(Ax_[c]), rounded);
            }
        });
        return problem_.T->entry_count() * applied_.size();
    }

  private:
    /// The columns of those sets of LinearOperator::column_period of which one or more takes part; if there are no
    /// sets, all columns.
    template <class TakesPart> void choose(const TakesPart& takes_part) {
        const Eigen::Index period = problem_.T->column_period();
        const std::size_t size = period > 0 ? static_cast<std::size_t>(period) : columns_.size();
        applied_.clear();
        for (std::size_t first = 0; first < columns_.size(); first += size) {
            const std::size_t end = std::min(columns_.size(), first + size);
            if (std::any_of(columns_.begin() + static_cast<std::ptrdiff_t>(first),
                            columns_.begin() + static_cast<std::ptrdiff_t>(end), takes_part)) {
                for (std::size_t c = first; c < end; ++c) {
                    applied_.push_back(c);
                }
            }
        }
    }

    template <class Operands> void multiply(Operands& operands) {
        operands.resize(problem_.g.rows(), static_cast<Eigen::Index>(applied_.size()));
        for_rows([&](std::size_t c, Eigen::Index at, const auto& rows) {
            operands(rows, at) = (columns_[c].operand()(rows) / unit_[c]).template cast<typename Operands::Scalar>();
        });
        problem_.T->apply_to(operands, Tx_, execution_);
    }

    /// Calls `act(c)` for each column that T is applied to.
    template <class Act> void for_each(const Act& act) {
        difusa::parallel_for(applied_.size(), 1, by_column_, [&](std::size_t begin, std::size_t end, unsigned) {
            for (std::size_t k = begin; k < end; ++k) {
                act(applied_[k]);
            }
        });
    }

    /// Calls `act(c, place among those applied, rows)` for some rows of all of them at a time: these fit in a cache.
    template <class Act> void for_rows(const Act& act) {
        difusa::parallel_for(
            static_cast<std::size_t>(problem_.g.rows()), 256, execution_.silent(),
            [&](std::size_t begin, std::size_t end, unsigned) {
                for (std::size_t k = 0; k < applied_.size(); ++k) {
                    act(applied_[k], static_cast<Eigen::Index>(k),
                        Eigen::seqN(static_cast<Eigen::Index>(begin), static_cast<Eigen::Index>(end - begin)));
                }
            });
    }

    const difusa::SolveProblem& problem_;
    std::vector<Column>& columns_;
    const difusa::Execution &by_column_, &execution_;
    std::vector<std::size_t> applied_; ///< columns that T is applied to
    Values x_, Tx_;
    difusa::SingleValues x_single_;
    std::vector<Vector> Ax_;
    std::vector<double> unit_; ///< of the operands
};

class Krylov final : public difusa::Solver {
  public:
    explicit Krylov(const difusa::Parameters& parameters)
        : restart_(static_cast<std::size_t>(parameters.integer("restart"))) {}

    SolveSummary solve(const difusa::SolveProblem& problem, const difusa::SolveOptions& options,
                       const difusa::Execution& execution) const override {
        // Many columns, or short ones, are handled side by side; of few long ones, each is divided.
        difusa::Execution by_column = execution.silent(), of_column = by_column;
        const auto threads = static_cast<Eigen::Index>(execution.threads);
        if (problem.g.cols() >= std::min(4 * threads, difusa::block_count(problem.g.rows()))) {
            of_column.threads = 1;
        } else {
            by_column.threads = 1;
        }
        std::vector<Column> columns;
        for (Eigen::Index c = 0; c < problem.g.cols(); ++c) {
            columns.emplace_back(problem.g.col(c), options, restart_, of_column);
        }
        Products products(problem, columns, by_column, execution);
        difusa::Showing showing(options);
        SolveSummary summary;
        bool first = true;
        while (!std::all_of(columns.begin(), columns.end(), [](const Column& column) { return column.done(); })) {
            execution.check();
            // True residuals are found once all spaces are complete, with one product for all of them. The first
            // ones need not be exact: they begin the spaces.
            const bool residuals = std::all_of(columns.begin(), columns.end(), [](const Column& column) {
                return column.done() || column.awaits_residual();
            });
            const auto takes_part = [&](const Column& column) {
                return !column.done() && column.awaits_residual() == residuals;
            };
            summary.entries_touched +=
                products.advance(takes_part, problem.T->prefers_single() && (first || !residuals));
            first = false;
            show(columns, summary.entries_touched, showing);
        }
        summary.h.resize(problem.g.rows(), problem.g.cols());
        for (std::size_t c = 0; c < columns.size(); ++c) {
            const Column& column = columns[c];
            summary.h.col(static_cast<Eigen::Index>(c)) = column.h();
            const double residual = column.history().back();
            summary.residual = difusa::larger(summary.residual, residual);
            summary.residual_history.push_back(column.history());
            summary.iterations = std::max(summary.iterations, column.iterations());
            if (column.reason() != SolveSummary::Reason::converged) {
                summary.reason = column.reason();
            }
            if (options.stop == difusa::StopBy::change) {
                summary.change = difusa::larger(summary.change.value_or(0.0), column.change());
            }
        }
        showing.show({static_cast<std::size_t>(summary.iterations) * static_cast<std::size_t>(summary.h.rows()),
                      summary.entries_touched, summary.residual, summary.h});
        return difusa::judged(std::move(summary), options);
    }

  private:
    /// The estimates of all columns, if that is due.
    static void show(const std::vector<Column>& columns, std::size_t entries, difusa::Showing& showing) {
        std::size_t relaxations = 0;
        double residual = 0.0;
        for (const Column& column : columns) {
            relaxations = std::max(relaxations, static_cast<std::size_t>(column.iterations()) *
                                                    static_cast<std::size_t>(column.h().size()));
            residual = difusa::larger(residual, column.history().back());
        }
        if (!showing.is_due(relaxations)) {
            return;
        }
        Values h(columns.front().h().size(), static_cast<Eigen::Index>(columns.size()));
        for (std::size_t c = 0; c < columns.size(); ++c) {
            h.col(static_cast<Eigen::Index>(c)) = columns[c].estimate();
        }
        showing.show({relaxations, entries, residual, h});
    }

    std::size_t restart_;
};

} // namespace

DIFUSA_PLUGIN(solver, "krylov", Krylov, "Restarted GMRES: few iterations at high reflectance.",
              {{"restart", difusa::ParameterSpec::Type::integer, "50", "iterations before a restart", 2, 1000, {}}})
