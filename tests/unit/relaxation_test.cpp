// Methods that relax one unknown after the other, each against a naive implementation on a dense matrix.
#include <difusa/algebra/dense.h>
#include <difusa/algebra/factors.h>
#include <difusa/algebra/solver.h>
#include <difusa/core/error.h>

#include <support/dense_operator.h>
#include <support/plugins.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

namespace difusa::relaxation_test {
namespace {

using test::DenseOperator;

constexpr Eigen::Index n = 40;

/// T = K diag(rho) with a diagonal, as where a basis function lights itself, and row sums of K of at most 1.
struct Room {
    Values rho, g;
    DenseOperator T;

    explicit Room(double most_rho, Eigen::Index channels = 1) : rho(n, channels), g(n, channels), T(matrix()) {
        RandomStream random(3, "room");
        for (Eigen::Index i = 0; i < n; ++i) {
            for (Eigen::Index c = 0; c < channels; ++c) {
                rho(i, c) = most_rho * random.uniform();
                g(i, c) = random.uniform();
            }
        }
        T = DenseOperator(T.matrix(), rho);
    }
    static Eigen::MatrixXd matrix() {
        RandomStream random(2, "matrix");
        const Eigen::MatrixXd K = test::random_nonnegative(n, 0.6, random);
        return K / K.rowwise().sum().maxCoeff();
    }
    Eigen::MatrixXd dense(Eigen::Index c = 0) const { return T.matrix() * Eigen::VectorXd(rho.col(c)).asDiagonal(); }
    SolveProblem problem() const { return {&T, g}; }
};

SolveSummary solve(const std::string& name, const Room& room, const SolveOptions& options,
                   const Execution& execution = {}) {
    return test::plugin<Solver>(name)->solve(room.problem(), options, execution);
}

SolveOptions patient(double tolerance = 1e-12, int iterations = 10'000) {
    SolveOptions options;
    options.tolerance = tolerance;
    options.max_iterations = iterations;
    return options;
}

/// All iterates that are shown.
struct Shown {
    std::vector<std::size_t> relaxations;
    std::vector<Values> h;
    SolveOptions in(SolveOptions options) {
        options.watch = [this](const Iterate& iterate) {
            relaxations.push_back(iterate.relaxations);
            h.push_back(iterate.h);
        };
        return options;
    }
};

TEST(GaussSeidel, IteratesAreThoseOfTheDenseMethod) {
    const Room room(0.9);
    const Eigen::MatrixXd T = room.dense();
    for (const double omega : {1.0, 1.1, 0.7}) {
        Eigen::VectorXd h = room.g.col(0);
        for (int sweeps = 0; sweeps <= 5; ++sweeps) {
            const SolveSummary summary =
                solve("gauss-seidel:relaxation=" + std::to_string(omega), room, patient(1e-14, sweeps));
            // Both sum 40 products of numbers below 1 for each unknown, in another order.
            EXPECT_LT((summary.h.col(0) - h).cwiseAbs().maxCoeff(), 1e-13 * h.maxCoeff()) << omega << ", " << sweeps;
            for (Eigen::Index i = 0; i < n; ++i) {
                const double others = T.row(i).dot(h) - T(i, i) * h[i];
                h[i] = omega * (room.g(i, 0) + others) / (1.0 - T(i, i)) + (1.0 - omega) * h[i];
            }
        }
    }
}

TEST(GaussSeidel, TouchesAsManyEntriesInASweepAsAProductDoes) {
    const Room room(0.9);
    const auto touched = [&](int sweeps) {
        return solve("gauss-seidel", room, patient(1e-14, sweeps)).entries_touched;
    };
    const std::shared_ptr<const Factors> factors = room.T.factors({});
    EXPECT_EQ(touched(5) - touched(4), factors->A->entry_count() + factors->Q.row.size());
}

/// Relaxes the unknown with the largest weighted residual, again and again.
struct NaiveGreedy {
    Eigen::MatrixXd T;
    Eigen::VectorXd x, r, weight;
    double omega = 1.0;

    void step() {
        Eigen::Index i = 0;
        r.cwiseAbs().cwiseProduct(weight).maxCoeff(&i);
        const double delta = omega * r[i] / (1.0 - T(i, i));
        x[i] += delta;
        r += delta * T.col(i);
        r[i] -= delta;
    }
};

TEST(Southwell, RelaxesTheLargestResidualEachTime) {
    const Room room(0.9);
    const Eigen::MatrixXd T = room.dense();
    for (const double omega : {1.0, 1.3}) {
        const Eigen::VectorXd g = room.g.col(0);
        NaiveGreedy naive{T, g, T * g, Eigen::VectorXd::Ones(n), omega};
        Shown shown;
        solve("southwell:relaxation=" + std::to_string(omega), room, shown.in(patient(1e-14, 3)));
        ASSERT_GT(shown.h.size(), 8U);
        std::size_t steps = 0;
        for (std::size_t k = 0; k < shown.h.size(); ++k) {
            for (; steps < shown.relaxations[k]; ++steps) {
                naive.step();
            }
            EXPECT_LT((shown.h[k].col(0) - naive.x).cwiseAbs().maxCoeff(), 1e-12) << "after " << steps << " steps";
        }
        EXPECT_EQ(steps, 3U * n);
    }
}

/// Some unknowns light few others and some light all, all of them in dyadic numbers, so that there are ties: the first
/// of the largest is relaxed, and every number is exact.
TEST(GreedyMethods, TakeTheFirstOfTheLargestWhetherFewResidualsChangeOrMany) {
    constexpr Eigen::Index size = 200;
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(size, size);
    for (Eigen::Index i = 0; i < size; ++i) {
        K((i + 1) % size, i) = K((i + 7) % size, i) = 0.25;
        if (i % 16 == 5) {
            K.col(i).setConstant(0x1p-9);
            K(i, i) = 0.0;
        }
    }
    Values rho(size, 1), g(size, 1);
    for (Eigen::Index i = 0; i < size; ++i) {
        rho(i, 0) = i % 3 == 0 ? 0.5 : 1.0;
        g(i, 0) = i % 5 == 0 ? 2.0 : 1.0;
    }
    const DenseOperator T(K, rho);
    const Eigen::MatrixXd dense = K * Eigen::VectorXd(rho.col(0)).asDiagonal();
    for (const bool shooting : {false, true}) {
        Eigen::VectorXd x = g.col(0), r = dense * x;
        if (shooting) {
            x.setZero();
            r = g.col(0);
        }
        Shown shown;
        test::plugin<Solver>(shooting ? "progressive:ambient=no" : "southwell")
            ->solve({&T, g}, shown.in(patient(1e-14, 2)), {});
        std::size_t steps = 0;
        for (std::size_t k = 0; k + 1 < shown.h.size(); ++k) { // the last is shown twice
            for (; steps < shown.relaxations[k]; ++steps) {
                Eigen::Index largest = 0;
                for (Eigen::Index i = 1; i < size; ++i) {
                    const double weight = shooting ? rho(i, 0) : 1.0, other = shooting ? rho(largest, 0) : 1.0;
                    largest = weight * std::abs(r[i]) > other * std::abs(r[largest]) ? i : largest;
                }
                const double delta = r[largest];
                x[largest] += delta;
                r += delta * dense.col(largest);
                r[largest] -= delta;
            }
            EXPECT_EQ(Eigen::VectorXd(shown.h[k].col(0)), shooting ? Eigen::VectorXd(x + r) : x)
                << "after " << steps << " steps";
        }
        EXPECT_GT(steps, 200U);
    }
}

TEST(Progressive, ShootsTheMostUnshotPowerAndShowsTheAmbientTerm) {
    const Room room(0.8);
    const Eigen::VectorXd rho = room.rho.col(0);
    const double mean = rho.mean();
    for (const bool ambient : {true, false}) {
        NaiveGreedy naive{room.dense(), Eigen::VectorXd::Zero(n), room.g.col(0), rho};
        Shown shown;
        solve(ambient ? "progressive" : "progressive:ambient=no", room, shown.in(patient(1e-14, 3)));
        std::size_t steps = 0;
        for (std::size_t k = 0; k + 1 < shown.h.size(); ++k) {
            for (; steps < shown.relaxations[k]; ++steps) {
                naive.step();
            }
            // Every unknown has an area of 1: mean unshot radiosity, times the sum of all reflections.
            const double term = ambient ? rho.dot(naive.r) / n / (1.0 - mean) : 0.0;
            EXPECT_LT((shown.h[k].col(0).array() - (naive.x + naive.r).array() - term).abs().maxCoeff(), 1e-12)
                << "after " << steps << " shots";
        }
    }
}

TEST(Progressive, ReachesTheSolutionFromBelowAndTheAmbientTermIsWithdrawn) {
    const Room room(0.95);
    const Eigen::VectorXd exact = solve_dense(Eigen::MatrixXd::Identity(n, n) - room.dense(), room.g.col(0));
    Shown without, with;
    const SolveSummary summary = solve("progressive:ambient=no", room, without.in(patient(1e-10)));
    ASSERT_TRUE(summary.converged());
    Eigen::VectorXd before = Eigen::VectorXd::Zero(n);
    for (const Values& h : without.h) {
        EXPECT_TRUE((h.col(0).array() >= before.array() - 1e-13).all());
        EXPECT_TRUE((h.col(0).array() <= exact.array() + 1e-12).all());
        before = h.col(0);
    }
    EXPECT_EQ(solve("progressive", room, with.in(patient(1e-10))).h, summary.h);
    ASSERT_EQ(with.h.size(), without.h.size());
    EXPECT_GT((with.h.front() - without.h.front()).minCoeff(), 0.1);
    EXPECT_EQ(with.h.back(), summary.h);
}

TEST(Progressive, LosesNoEnergy) {
    // A closed room of equal patches: K is symmetric and its rows sum to 1, so that light lands in full.
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n, n);
    for (Eigen::Index i = 0; i < n; ++i) {
        for (const Eigen::Index d : {1, 7, 13}) {
            K(i, (i + d) % n) += 1.0 / 6.0;
            K((i + d) % n, i) += 1.0 / 6.0;
        }
    }
    Room room(0.8);
    room.T = DenseOperator(K, room.rho);
    const Eigen::VectorXd g = room.g.col(0), rho = room.rho.col(0);
    Shown shown;
    solve("progressive:ambient=no", room, shown.in(patient(1e-14, 4)));
    NaiveGreedy naive{room.dense(), Eigen::VectorXd::Zero(n), g, rho};
    std::size_t steps = 0;
    for (std::size_t k = 0; k + 1 < shown.h.size(); ++k) {
        for (; steps < shown.relaxations[k]; ++steps) {
            naive.step();
        }
        // What came in is absorbed where it was shot on, (1 - rho) x, or is still unshot.
        EXPECT_NEAR((1.0 - rho.array()).matrix().dot(naive.x) + naive.r.sum(), g.sum(), 1e-12 * g.sum());
        // What has arrived anywhere is the light and what was shot: no more and no less.
        EXPECT_LT((shown.h[k].col(0) - g - room.dense() * naive.x).cwiseAbs().maxCoeff(), 1e-12);
    }
}

TEST(Progressive, LightOnBlackSurfacesIsPartOfTheResult) {
    Room room(0.9);
    room.rho.topRows(10).setZero();
    room.T = DenseOperator(room.T.matrix(), room.rho);
    const SolveSummary summary = solve("progressive", room, patient(1e-11));
    ASSERT_TRUE(summary.converged());
    EXPECT_LT((room.g + room.dense() * summary.h - summary.h).cwiseAbs().maxCoeff(), 1.1e-11 * room.g.maxCoeff());
}

TEST(Relaxation, HasTheSameBitsForAnyNumberOfThreads) {
    const Room room(0.9, 5);
    for (const char* name : {"gauss-seidel:relaxation=1.2", "southwell", "progressive"}) {
        const SolveSummary one = solve(name, room, patient());
        for (const unsigned threads : {2U, 3U, 8U}) {
            const SolveSummary many = solve(name, room, patient(), Execution{threads});
            EXPECT_EQ(many.h, one.h) << name;
            EXPECT_EQ(many.residual_history, one.residual_history) << name;
            EXPECT_EQ(many.entries_touched, one.entries_touched) << name;
        }
    }
}

TEST(Relaxation, OverRelaxationDoesNotChangeTheSolution) {
    const Room room(0.9);
    const Values h = solve("krylov", room, patient()).h;
    for (const char* name : {"jacobi", "gauss-seidel", "southwell", "progressive"}) {
        for (const char* omega : {"0.6", "1.1"}) {
            const SolveSummary other = solve(std::string(name) + ":relaxation=" + omega, room, patient());
            ASSERT_TRUE(other.converged()) << name << omega << other.sentence();
            EXPECT_LT((other.h - h).cwiseAbs().maxCoeff(), 2e-12 / (1.0 - 0.9)) << name << omega;
        }
    }
}

/// Without rows and columns.
class Unstored final : public LinearOperator {
  public:
    std::size_t rows() const override { return 3; }
    std::size_t columns() const override { return 3; }
    void apply(const Values& x, Values& y, const Execution& /*execution*/) const override { y = 0.5 * x; }
    void apply_transpose(const Values& x, Values& y, const Execution& /*execution*/) const override { y = 0.5 * x; }
    std::size_t entry_count() const override { return 3; }
};

TEST(Relaxation, RefusesAnOperatorWithoutRowsAndColumns) {
    const Unstored T;
    for (const std::string name : {"gauss-seidel", "southwell", "progressive"}) {
        const auto solver = test::plugin<Solver>(name);
        EXPECT_TRUE(solver->needs_factors());
        EXPECT_THAT(
            [&] {
                solver->solve({&T, Values::Ones(3, 1)}, {}, Execution{});
            },
            testing::ThrowsMessage<UsageError>(
                testing::AllOf(testing::HasSubstr("--solver " + name), testing::HasSubstr("use krylov or jacobi"))));
    }
    for (const char* name : {"jacobi", "krylov"}) {
        EXPECT_FALSE(test::plugin<Solver>(name)->needs_factors());
        EXPECT_NEAR(test::plugin<Solver>(name)->solve({&T, Values::Ones(3, 1)}, {}, Execution{}).h(0, 0), 2.0, 1e-5);
    }
}

TEST(StopBy, ChangeEndsWhenAnIterationChangesLittle) {
    const Room room(0.9);
    for (const std::string& name : test::plugin_names<Solver>()) {
        SCOPED_TRACE(name);
        SolveOptions by_change = patient(1e-5);
        by_change.stop = StopBy::change;
        const SolveSummary summary = solve(name, room, by_change);
        ASSERT_TRUE(summary.converged());
        ASSERT_TRUE(summary.change.has_value());
        EXPECT_LE(*summary.change, 1e-5);
        EXPECT_GT(*summary.change, 0.0);
        EXPECT_THAT(summary.sentence(), testing::HasSubstr("relative change"));
        EXPECT_FALSE(solve(name, room, patient(1e-5)).change.has_value());
        // It is what it says: the iteration before the last is further from the last than the tolerance allows to stop.
        by_change.max_iterations = summary.iterations - 1;
        const SolveSummary before = solve(name, room, by_change);
        EXPECT_EQ(before.reason, SolveSummary::Reason::max_iterations);
        EXPECT_NEAR((summary.h - before.h).cwiseAbs().maxCoeff() / room.g.maxCoeff(), *summary.change, 1e-12);
        EXPECT_GT(*before.change, 1e-5);
    }
}

TEST(Solvers, ShowIteratesFromTheFirstToTheLast) {
    const Room room(0.9);
    for (const std::string& name : test::plugin_names<Solver>()) {
        SCOPED_TRACE(name);
        Shown shown;
        const SolveSummary summary = solve(name, room, shown.in(patient(1e-10)));
        ASSERT_GT(shown.h.size(), 3U);
        EXPECT_EQ(shown.relaxations.front(), 0U);
        EXPECT_TRUE(std::is_sorted(shown.relaxations.begin(), shown.relaxations.end()));
        EXPECT_EQ(shown.h.back(), summary.h);
        EXPECT_LT(shown.h.size(), 40U);
        EXPECT_EQ(summary.h, solve(name, room, patient(1e-10)).h) << "watching changes nothing";
        EXPECT_GT(summary.entries_touched, 0U);
    }
}

} // namespace
} // namespace difusa::relaxation_test
