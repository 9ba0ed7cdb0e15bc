// Least squares with unknowns that are not negative.
#include <difusa/algebra/dense.h>
#include <difusa/algebra/nonnegative.h>
#include <difusa/core/random.h>

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace difusa::nonnegative_test {
namespace {

Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns, RandomStream& stream) {
    Eigen::MatrixXd A(rows, columns);
    for (double& each : A.reshaped()) {
        each = 2.0 * stream.uniform() - 0.7;
    }
    return A;
}

/// The best of all choices of unknowns that are not 0.
Eigen::VectorXd by_brute_force(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
    Eigen::VectorXd best = Eigen::VectorXd::Zero(A.cols());
    double least = b.norm();
    for (unsigned set = 1; set < 1U << A.cols(); ++set) {
        std::vector<Eigen::Index> free;
        for (Eigen::Index k = 0; k < A.cols(); ++k) {
            if ((set >> k & 1U) != 0) {
                free.push_back(k);
            }
        }
        const Eigen::MatrixXd columns = A(Eigen::all, free);
        const Eigen::VectorXd x = least_squares(columns, b);
        const double miss = (columns * x - b).norm();
        if (x.minCoeff() >= 0.0 && miss < least) {
            least = miss;
            best.setZero();
            best(free) = x;
        }
    }
    return best;
}

TEST(NonnegativeLeastSquares, FindsWhatBruteForceFinds) {
    RandomStream stream(1, "problems");
    std::size_t bound = 0;
    for (int trial = 0; trial < 300; ++trial) {
        const Eigen::Index unknowns = 1 + static_cast<Eigen::Index>(stream.below(5));
        const Eigen::MatrixXd A = random_matrix(7, unknowns, stream);
        const Eigen::VectorXd b = random_matrix(7, 1, stream);
        const Eigen::VectorXd x = nonnegative_least_squares(A, b), expected = by_brute_force(A, b);
        ASSERT_GE(x.minCoeff(), 0.0);
        ASSERT_LE((x - expected).norm(), 1e-9 * (1.0 + expected.norm())) << trial;
        bound += static_cast<std::size_t>((x.array() == 0.0).count());
    }
    EXPECT_GT(bound, 300U) << "constraints were active";
}

TEST(NonnegativeLeastSquares, RecoversAnExactSolution) {
    RandomStream stream(2, "problems");
    const Eigen::MatrixXd A = random_matrix(40, 6, stream);
    Eigen::VectorXd x(6);
    x << 0.5, 0.0, 3.0, 1e-3, 0.0, 7.0;
    EXPECT_LE((nonnegative_least_squares(A, A * x) - x).norm(), 1e-12);
}

TEST(NonnegativeLeastSquares, CopesWithDegenerateColumns) {
    Eigen::MatrixXd A(3, 4);
    A << 1, 1, 0, 2, 2, 2, 0, 4, 0, 0, 0, 0; // one direction only, and one column without any
    const Eigen::VectorXd x = nonnegative_least_squares(A, Eigen::Vector3d(5, 10, 1));
    EXPECT_GE(x.minCoeff(), 0.0);
    EXPECT_LE((A * x - Eigen::Vector3d(5, 10, 0)).norm(), 1e-12);
    EXPECT_EQ(nonnegative_least_squares(A, Eigen::Vector3d(-1, -2, 0)), Eigen::VectorXd::Zero(4));
    EXPECT_EQ(nonnegative_least_squares(A, Eigen::Vector3d::Zero()), Eigen::VectorXd::Zero(4));
    EXPECT_EQ(nonnegative_least_squares(Eigen::MatrixXd(3, 0), Eigen::Vector3d::Ones()).size(), 0);
}

} // namespace
} // namespace difusa::nonnegative_test
