#include <difusa/algebra/dense.h>
#include <difusa/algebra/solver.h>
#include <difusa/core/error.h>

#include <support/dense_operator.h>
#include <support/plugins.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace difusa::solvers_test {
namespace {

using test::DenseOperator;
using Reason = SolveSummary::Reason;

/// T = K diag(rho) with a nonnegative K of row sums up to `norm`, three channels of different reflectance and light.
struct Problem {
    Values rho, light;
    DenseOperator T;

    Problem(Eigen::Index n, double norm, double most_rho, std::uint64_t seed, Eigen::Index channels = 3)
        : rho(n, channels), light(n, channels), T(matrix(n, norm, seed)) {
        RandomStream random(seed, "light");
        for (Eigen::Index c = 0; c < channels; ++c) {
            for (Eigen::Index i = 0; i < n; ++i) {
                rho(i, c) = most_rho * (c == 0 ? 1.0 : random.uniform());
                light(i, c) = std::pow(100.0, static_cast<double>(c)) * random.uniform();
            }
        }
        T = DenseOperator(T.matrix(), rho);
    }
    static Eigen::MatrixXd matrix(Eigen::Index n, double norm, std::uint64_t seed) {
        RandomStream random(seed, "matrix");
        const Eigen::MatrixXd K = test::random_nonnegative(n, n > 2 ? 0.5 : 1.0, random);
        return K * (norm / K.rowwise().sum().maxCoeff());
    }
    SolveProblem problem() const { return {&T, light}; }

    Values exact() const {
        Values h(light.rows(), light.cols());
        for (Eigen::Index c = 0; c < light.cols(); ++c) {
            const Eigen::MatrixXd A = Eigen::MatrixXd::Identity(light.rows(), light.rows()) -
                                      T.matrix() * Eigen::VectorXd(rho.col(c)).asDiagonal();
            h.col(c) = solve_dense(A, light.col(c));
        }
        return h;
    }
};

SolveSummary solve(const std::string& name, const SolveProblem& problem, const SolveOptions& options = {}) {
    return test::plugin<Solver>(name)->solve(problem, options, Execution{});
}

void expect_true_history(const SolveSummary& summary, const SolveProblem& problem) {
    Values r;
    const std::vector<double> residual = relative_residual(problem, summary.h, r, Execution{});
    ASSERT_EQ(summary.residual_history.size(), residual.size());
    double largest = 0.0;
    for (std::size_t c = 0; c < residual.size(); ++c) {
        EXPECT_NEAR(summary.residual_history[c].back(), residual[c], 1e-14) << "channel " << c;
        largest = std::max(largest, residual[c]);
    }
    EXPECT_NEAR(summary.residual, largest, 1e-14);
}

TEST(Solvers, AgreeWithTheDirectSolution) {
    for (const std::string& name : test::plugin_names<Solver>()) {
        for (const Eigen::Index n : {1, 2, 7, 120}) {
            for (const double rho : {0.0, 0.3, 0.9, 0.99}) {
                SCOPED_TRACE(name + ", " + std::to_string(n) + " unknowns, rho " + std::to_string(rho));
                const Problem p(n, 1.0, rho, static_cast<std::uint64_t>(n));
                SolveOptions options;
                options.tolerance = 1e-9;
                options.max_iterations = 5000;
                const SolveSummary summary = solve(name, p.problem(), options);
                ASSERT_TRUE(summary.converged()) << summary.sentence();
                EXPECT_LE(summary.residual, options.tolerance);
                expect_true_history(summary, p.problem());
                // ‖h - h*‖∞ = ‖A⁻¹ r‖∞ <= ‖r‖∞ / (1 - rho ‖K‖∞), and ‖K‖∞ = 1.
                const Values error = summary.h - p.exact();
                for (Eigen::Index c = 0; c < 3; ++c) {
                    EXPECT_LE(error.col(c).cwiseAbs().maxCoeff(),
                              1.01 * options.tolerance * p.light.col(c).maxCoeff() / (1.0 - rho) +
                                  1e-13 * summary.h.col(c).maxCoeff());
                }
                EXPECT_GT(p.T.applications, 0);
            }
        }
    }
}

TEST(Solvers, CountEveryIteration) {
    for (const std::string& name : test::plugin_names<Solver>()) {
        const Problem p(50, 1.0, 0.8, 3, 1);
        const SolveSummary summary = solve(name, p.problem());
        ASSERT_EQ(summary.residual_history.size(), 1U);
        EXPECT_EQ(summary.residual_history[0].size(), static_cast<std::size_t>(summary.iterations) + 1) << name;
        EXPECT_GT(summary.iterations, 1) << name;
    }
}

TEST(Solvers, StopWhereNothingIsAllowedOrNeeded) {
    for (const std::string& name : test::plugin_names<Solver>()) {
        SCOPED_TRACE(name);
        const Problem p(20, 1.0, 0.8, 4);
        SolveOptions options;
        options.max_iterations = 0;
        const SolveSummary none_allowed = solve(name, p.problem(), options);
        EXPECT_EQ(none_allowed.reason, Reason::max_iterations);
        EXPECT_EQ(none_allowed.iterations, 0);
        EXPECT_FALSE(none_allowed.converged());
        EXPECT_THAT(none_allowed.sentence(), testing::HasSubstr("limit"));
        expect_true_history(none_allowed, p.problem());
        options.max_iterations = 3;
        options.tolerance = 1e-12;
        const SolveSummary three = solve(name, p.problem(), options);
        EXPECT_EQ(three.reason, Reason::max_iterations);
        EXPECT_EQ(three.iterations, 3);
        expect_true_history(three, p.problem());

        SolveProblem dark = p.problem();
        dark.g.setZero();
        const SolveSummary nothing = solve(name, dark);
        EXPECT_TRUE(nothing.converged());
        EXPECT_EQ(nothing.h, dark.g);
        EXPECT_EQ(nothing.iterations, 0);

        SolveProblem one_dark = p.problem();
        one_dark.g.col(1).setZero();
        const SolveSummary two = solve(name, one_dark);
        EXPECT_TRUE(two.converged());
        EXPECT_EQ(two.h.col(1).cwiseAbs().maxCoeff(), 0.0);

        const DenseOperator absorbs(p.T.matrix(), Values::Zero(20, 1));
        const SolveProblem black{&absorbs, p.light};
        EXPECT_EQ(solve(name, black).h, black.g);
    }
}

TEST(Solvers, DoNotDependOnTheUnitOfLight) {
    for (const std::string& name : test::plugin_names<Solver>()) {
        const Problem p(40, 1.0, 0.7, 5);
        SolveProblem bright = p.problem();
        bright.g *= 0x1p70;
        const SolveSummary a = solve(name, p.problem()), b = solve(name, bright);
        EXPECT_EQ(b.h, a.h * 0x1p70) << name;
        EXPECT_EQ(b.iterations, a.iterations) << name;
        for (const double unit : {0x1p-800, 0x1p800}) { // whose square is no double
            SolveProblem other = p.problem();
            other.g *= unit;
            const SolveSummary c = solve(name, other);
            EXPECT_TRUE(c.converged()) << name << c.sentence();
            EXPECT_EQ(c.h, a.h * unit) << name;
            EXPECT_EQ(c.iterations, a.iterations) << name;
        }
    }
}

TEST(Solvers, AcceptAResidualOfMereRounding) {
    for (const std::string& name : test::plugin_names<Solver>()) {
        const Problem p(40, 1.0, 0.5, 5);
        SolveOptions options;
        options.tolerance = 1e-30;
        options.max_iterations = 200;
        const SolveSummary summary = solve(name, p.problem(), options);
        EXPECT_TRUE(summary.converged()) << name;
        EXPECT_THAT(summary.sentence(), testing::StartsWith("converged to rounding after"));
        options.tolerance = 1e-9;
        EXPECT_THAT(solve(name, p.problem(), options).sentence(), testing::StartsWith("converged after")) << name;
    }
}

TEST(Solvers, NeverCallNonsenseConverged) {
    for (const std::string& name : test::plugin_names<Solver>()) {
        SCOPED_TRACE(name);
        SolveOptions options;
        options.max_iterations = 2000;
        Problem p(30, 1.0, 0.9, 6);
        for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
            Eigen::MatrixXd K = p.T.matrix();
            K(3, 4) = bad;
            const DenseOperator broken(K, p.rho);
            EXPECT_FALSE(solve(name, {&broken, p.light}, options).converged()) << "K has " << bad;
            SolveProblem lit = p.problem();
            lit.g(7, 2) = bad;
            EXPECT_FALSE(solve(name, lit, options).converged()) << "the light has " << bad;
        }
        // Singular: light in a closed room that absorbs nothing.
        const DenseOperator closed(Eigen::MatrixXd::Constant(10, 10, 0.1));
        const Values ones = Values::Ones(10, 1);
        const SolveSummary summary = solve(name, {&closed, ones}, options);
        EXPECT_FALSE(summary.converged()) << summary.sentence();
    }
}

TEST(Jacobi, DivergesWhereTheSeriesDoes) {
    const Problem p(40, 6.0, 0.9, 7);
    ASSERT_GT(largest_eigenvalue(p.T.matrix()) * 0.9, 1.0);
    SolveOptions options;
    options.max_iterations = 100'000;
    const SolveSummary summary = solve("jacobi", p.problem(), options);
    EXPECT_EQ(summary.reason, Reason::diverged);
    EXPECT_THAT(summary.sentence(), testing::HasSubstr("diverged"));
    EXPECT_THAT(summary.remedy(), testing::HasSubstr("--solver krylov"));
}

TEST(Jacobi, ContractsByTheSpectralRadius) {
    const Problem p(60, 1.0, 0.95, 8, 1);
    const double radius = largest_eigenvalue(p.T.matrix() * Eigen::VectorXd(p.rho.col(0)).asDiagonal());
    SolveOptions options;
    options.tolerance = 1e-10;
    const std::vector<double> history = solve("jacobi", p.problem(), options).residual_history[0];
    // The other eigenvalues of a random nonnegative matrix are far below the first: their part has died out.
    ASSERT_GT(history.size(), 40U);
    for (std::size_t i = 20; i < 40; ++i) {
        EXPECT_NEAR(history[i + 1] / history[i], radius, 1e-8);
    }
}

TEST(Jacobi, AddsOneBounceAnIteration) {
    const Problem p(25, 1.0, 0.6, 9, 1);
    SolveOptions options;
    options.tolerance = 1e-15;
    Eigen::VectorXd bounce = p.light.col(0), sum = bounce;
    for (int bounces = 0; bounces < 6; ++bounces) {
        options.max_iterations = bounces;
        EXPECT_LT((solve("jacobi", p.problem(), options).h.col(0) - sum).cwiseAbs().maxCoeff(), 1e-14);
        bounce = p.T.matrix() * p.rho.col(0).cwiseProduct(bounce);
        sum += bounce;
    }
}

TEST(Krylov, NeedsFewerIterationsAtHighReflectanceAndItsResidualNeverGrows) {
    // A slow equation: a path along which light wanders.
    constexpr Eigen::Index n = 200;
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n, n);
    for (Eigen::Index i = 0; i < n; ++i) {
        K(i, (i + 1) % n) = K(i, (i + n - 1) % n) = 0.5;
    }
    const DenseOperator path(K, Values::Constant(n, 1, 0.99));
    Values light = Values::Zero(n, 1);
    light(0, 0) = 1.0;
    const SolveProblem problem{&path, light};
    SolveOptions patient;
    patient.max_iterations = 5000;
    const SolveSummary jacobi = solve("jacobi", problem, patient);
    ASSERT_TRUE(jacobi.converged());
    for (const char* choice : {"krylov", "krylov:restart=10", "krylov:restart=2"}) {
        SCOPED_TRACE(choice);
        const SolveSummary krylov = solve(choice, problem, patient);
        ASSERT_TRUE(krylov.converged()) << krylov.sentence();
        EXPECT_LT(krylov.iterations, jacobi.iterations);
        EXPECT_LT((krylov.h - jacobi.h).cwiseAbs().maxCoeff(), 2e-6 / (1.0 - 0.99));
    }
    // GMRES never lets the 2-norm grow from one iteration to the next.
    double before = std::numeric_limits<double>::infinity();
    for (int iterations = 0; iterations < 60; ++iterations) {
        SolveOptions options;
        options.max_iterations = iterations;
        options.tolerance = 1e-14;
        Values r;
        relative_residual(problem, solve("krylov:restart=20", problem, options).h, r, Execution{});
        EXPECT_LE(r.norm(), before * (1.0 + 1e-12)) << iterations;
        before = r.norm();
    }
}

/// T, for which products of operands in single precision are preferred.
class SinglePreferred final : public LinearOperator {
  public:
    explicit SinglePreferred(const LinearOperator& T) : T_(T) {}
    std::size_t rows() const override { return T_.rows(); }
    std::size_t columns() const override { return T_.columns(); }
    std::size_t entry_count() const override { return T_.entry_count(); }
    Eigen::Index column_period() const override { return T_.column_period(); }
    bool prefers_single() const override { return true; }
    void apply(const Values& x, Values& y, const Execution& execution) const override {
        ++exact;
        T_.apply(x, y, execution);
    }
    void apply_single(const SingleValues& x, Values& y, const Execution& execution) const override {
        ++single;
        T_.apply(x.cast<double>(), y, execution);
    }
    void apply_transpose(const Values& x, Values& y, const Execution& execution) const override {
        T_.apply_transpose(x, y, execution);
    }

    mutable int exact = 0, single = 0;

  private:
    const LinearOperator& T_;
};

/// The true residual, found exactly, is what ends the iteration: rounded products cost iterations, not accuracy.
TEST(Krylov, IsAsAccurateWithOperandsInSinglePrecision) {
    for (const double rho : {0.5, 0.99}) {
        const Problem p(120, 1.0, rho, 12);
        const SinglePreferred T(p.T);
        for (const double tolerance : {1e-6, 1e-12}) {
            T.exact = T.single = 0;
            SolveOptions options;
            options.tolerance = tolerance;
            const SolveSummary summary = solve("krylov", {&T, p.light}, options);
            ASSERT_TRUE(summary.converged()) << summary.sentence();
            EXPECT_GT(T.single, 2 * T.exact); // one exact product ends each space
            expect_true_history(summary, p.problem());
            for (Eigen::Index c = 0; c < 3; ++c) {
                EXPECT_LE(summary.residual_history[static_cast<std::size_t>(c)].back(), tolerance);
                // ‖(I - T)^-1‖∞ is at most 1/(1 - rho).
                EXPECT_LT((summary.h - p.exact()).col(c).cwiseAbs().maxCoeff(),
                          1.01 * tolerance * p.light.col(c).maxCoeff() / (1.0 - rho) +
                              1e-12 * p.exact().col(c).maxCoeff());
            }
        }
    }
}

/// What the iteration knows of the residual is the true one but for the rounding of the operands, up to 2^-24 of each,
/// in a dozen products; and one product less is needed.
TEST(Krylov, NeedNotConfirmALooseResidual) {
    const Problem p(120, 1.0, 0.9, 12);
    const SinglePreferred T(p.T);
    SolveOptions options;
    options.tolerance = 0.05;
    const SolveSummary confirmed = solve("krylov", {&T, p.light}, options);
    EXPECT_EQ(T.exact, 1);
    const int products = T.single;
    T.exact = T.single = 0;
    options.confirm = false;
    const SolveSummary summary = solve("krylov", {&T, p.light}, options);
    ASSERT_TRUE(summary.converged()) << summary.sentence();
    EXPECT_EQ(summary.h, confirmed.h);
    EXPECT_EQ(T.exact, 0);
    EXPECT_EQ(T.single, products);
    Values r;
    const std::vector<double> residual = relative_residual(p.problem(), summary.h, r, Execution{});
    for (std::size_t c = 0; c < residual.size(); ++c) {
        EXPECT_LE(residual[c], options.tolerance);
        EXPECT_NEAR(summary.residual_history[c].back(), residual[c], 12 * 0x1p-24 / (1.0 - 0.9));
    }
}

TEST(Krylov, EndsAfterAsManyIterationsAsThereAreEigenvalues) {
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(12, 12);
    for (Eigen::Index i = 0; i < 12; ++i) {
        K(i, i) = i % 3 == 0 ? 0.1 : i % 3 == 1 ? 0.5 : 0.8;
    }
    const DenseOperator three(K);
    SolveOptions options;
    options.tolerance = 1e-12;
    const SolveSummary summary = solve("krylov", {&three, Values::Ones(12, 1)}, options);
    EXPECT_TRUE(summary.converged());
    EXPECT_LE(summary.iterations, 3);
}

/// Columns are independent equations: an operator that treats them alike lets them be solved together, but no column
/// notices the others.
TEST(Solvers, ColumnsAreSolvedAsEachWouldBeAlone) {
    for (const std::string& name : test::plugin_names<Solver>()) {
        SCOPED_TRACE(name);
        constexpr Eigen::Index n = 60, channels = 3, sets = 3;
        const Problem p(n, 1.0, 0.9, 11, channels);
        SolveProblem together{&p.T, Values(n, channels * sets)};
        RandomStream random(12, "light of sets");
        for (double& g : together.g.reshaped()) {
            g = random.uniform() - 0.2;
        }
        together.g.col(4).setZero();
        SolveOptions options;
        options.tolerance = 1e-10;
        const SolveSummary all = solve(name, together, options);
        ASSERT_TRUE(all.converged());
        int most = 0;
        for (Eigen::Index c = 0; c < channels * sets; ++c) {
            const DenseOperator own(p.T.matrix(), p.rho.col(c % channels));
            const SolveSummary alone = solve(name, {&own, together.g.col(c)}, options);
            ASSERT_TRUE(alone.converged());
            // Both have residuals below the tolerance, so that they differ by at most twice that times ‖(I - T)⁻¹‖∞,
            // which is 1 / (1 - 0.9) or less. What is left of columns that converged first is not iterated on.
            EXPECT_LE((all.h.col(c) - alone.h).cwiseAbs().maxCoeff(),
                      2.0 * options.tolerance / (1.0 - 0.9) * together.g.col(c).cwiseAbs().maxCoeff());
            most = std::max(most, alone.iterations);
        }
        EXPECT_EQ(all.iterations, most);
    }
}

/// Sets of columns that have converged take no further products, and the others keep their bits.
TEST(Solvers, KrylovLeavesOutSetsOfColumnsThatHaveConverged) {
    constexpr Eigen::Index n = 60, channels = 3;
    const Problem p(n, 1.0, 0.9, 13, channels);
    SolveOptions options;
    options.tolerance = 1e-10;
    Values g(n, 3 * channels);
    RandomStream random(14, "light of sets");
    for (double& each : g.reshaped()) {
        each = random.uniform();
    }
    g.middleCols(channels, channels).setZero();
    const SolveSummary all = solve("krylov", {&p.T, g}, options);
    Values others(n, 2 * channels);
    others << g.leftCols(channels), g.rightCols(channels);
    const SolveSummary two = solve("krylov", {&p.T, others}, options);
    ASSERT_TRUE(all.converged());
    EXPECT_EQ(all.entries_touched, two.entries_touched);
    EXPECT_EQ(all.h.leftCols(channels), two.h.leftCols(channels));
    EXPECT_EQ(all.h.rightCols(channels), two.h.rightCols(channels));
    EXPECT_EQ(all.h.middleCols(channels, channels).cwiseAbs().maxCoeff(), 0.0);
}

/// A column that converges while others go on: light along an eigenvector takes one iteration. Together they touch as
/// many entries as each by itself, and have the same bits.
TEST(Solvers, KrylovLeavesOutColumnsAsSoonAsTheyConverge) {
    constexpr Eigen::Index n = 60;
    const Problem p(n, 1.0, 0.9, 15, 1);
    Eigen::VectorXd eigenvector = Eigen::VectorXd::Ones(n);
    for (int step = 0; step < 1000; ++step) {
        eigenvector = (p.T.matrix() * p.rho.col(0).asDiagonal() * eigenvector).normalized();
    }
    SolveOptions options;
    options.tolerance = 1e-10;
    Values g(n, 3);
    g << p.light.col(0), eigenvector, p.light.col(0).reverse();
    const SolveSummary all = solve("krylov", {&p.T, g}, options);
    ASSERT_TRUE(all.converged());
    std::size_t entries = 0;
    std::vector<int> iterations;
    for (Eigen::Index c = 0; c < g.cols(); ++c) {
        const SolveSummary alone = solve("krylov", {&p.T, g.col(c)}, options);
        EXPECT_EQ(all.h.col(c), alone.h.col(0)) << "column " << c;
        entries += alone.entries_touched;
        iterations.push_back(alone.iterations);
    }
    EXPECT_EQ(all.entries_touched, entries);
    EXPECT_EQ(iterations[1], 1);
    EXPECT_GT(iterations[0], 3);
}

class Cancelled : public Progress {
    bool cancelled() const override { return true; }
};

TEST(Solvers, CanBeInterrupted) {
    Cancelled progress;
    const Problem p(10, 1.0, 0.5, 10);
    for (const std::string& name : test::plugin_names<Solver>()) {
        EXPECT_THROW(test::plugin<Solver>(name)->solve(p.problem(), {}, Execution{1, &progress}), Interrupted) << name;
    }
}

} // namespace
} // namespace difusa::solvers_test
