#include "support/sanitized.h"

#include <difusa/algebra/dense.h>
#include <difusa/algebra/spectral_radius.h>

#include <support/dense_operator.h>

#include <gtest/gtest.h>

namespace difusa::spectral_radius_test {
namespace {

using test::DenseOperator;

// Under the sanitizers up to 92 rows: the subspace of 40 vectors is restarted in these too.
const std::uint64_t matrices = test::sanitized() ? 7 : 20;

TEST(SpectralRadius, IsThatOfTheDenseMatrix) {
    for (std::uint64_t seed = 0; seed < matrices; ++seed) {
        RandomStream random(seed, "matrix");
        const auto n = static_cast<Eigen::Index>(2 + 15 * seed);
        const Eigen::MatrixXd K = test::random_nonnegative(n, seed % 2 == 0 ? 0.9 : 0.2, random);
        Values rho(n, 1);
        for (double& r : rho.reshaped()) {
            r = random.uniform();
        }
        const double exact = largest_eigenvalue(K * Eigen::VectorXd(rho.col(0)).asDiagonal());
        EXPECT_NEAR(spectral_radius(DenseOperator(K, rho), 40, 0.0, Execution{}), exact, 1e-9 * exact + 1e-12) << n;
    }
}

TEST(SpectralRadius, OfAClosedSceneIsOne) {
    // Row sums 1: the constant vector is the eigenvector.
    RandomStream random(1, "matrix");
    Eigen::MatrixXd K = test::random_nonnegative(80, 0.3, random);
    K.array().colwise() /= K.rowwise().sum().array().eval();
    EXPECT_NEAR(spectral_radius(DenseOperator(K), 40, 0.0, Execution{}), 1.0, 1e-14);
    EXPECT_NEAR(spectral_radius(DenseOperator(K, Values::Constant(80, 1, 0.25)), 40, 0.0, Execution{}), 0.25, 1e-14);
}

TEST(SpectralRadius, OfSeparateRoomsIsThatOfTheWorst) {
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(30, 30);
    K.topLeftCorner(28, 28).setConstant(0.5 / 28);
    K.bottomRightCorner(2, 2) << 0.0, 1.3, 1.3, 0.0;
    EXPECT_NEAR(spectral_radius(DenseOperator(K), 40, 0.0, Execution{}), 1.3, 1e-12);
}

/// The constant vector is an eigenvector, but not of the largest eigenvalue, which belongs to few unknowns.
TEST(SpectralRadius, OfAGapIsFound) {
    for (const Eigen::Index n : {30, 3000}) {
        Eigen::MatrixXd K = Eigen::MatrixXd::Constant(n, n, 0.9 / static_cast<double>(n - 2));
        K.rightCols(2).setZero();
        K.bottomLeftCorner(2, n - 2).setZero();
        K.bottomRightCorner(2, 2) << 0.9 + 0.15, -0.15, -0.15, 0.9 + 0.15; // eigenvalues 0.9 and 1.2
        EXPECT_NEAR(spectral_radius(DenseOperator(K), 40, 1e-5, Execution{}), 1.2, 1e-9) << n;
    }
}

TEST(SpectralRadius, EndsEarlyWhereTheEstimateHasSettled) {
    RandomStream random(2, "matrix");
    const Eigen::MatrixXd K = test::random_nonnegative(200, 0.5, random);
    const double exact = largest_eigenvalue(K);
    EXPECT_NEAR(spectral_radius(DenseOperator(K), 40, 1e-5, Execution{}), exact, 1e-5 * exact);
}

TEST(SpectralRadius, OfNothingIsNothing) {
    EXPECT_EQ(spectral_radius(DenseOperator(Eigen::MatrixXd::Zero(5, 5)), 40, 0.0, Execution{}), 0.0);
    EXPECT_EQ(spectral_radius(DenseOperator(Eigen::MatrixXd::Ones(5, 5), Values::Zero(5, 1)), 40, 0.0, Execution{}),
              0.0);
    // Light that passes through a chain once: nilpotent.
    Eigen::MatrixXd chain = Eigen::MatrixXd::Zero(6, 6);
    for (Eigen::Index i = 0; i + 1 < 6; ++i) {
        chain(i, i + 1) = 1.0;
    }
    EXPECT_LT(spectral_radius(DenseOperator(chain), 40, 0.0, Execution{}), 0.01);
}

} // namespace
} // namespace difusa::spectral_radius_test
