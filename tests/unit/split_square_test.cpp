#include <difusa/core/random.h>
#include <difusa/study/split_square.h>

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace difusa::split_square_test {
namespace {

/// Of variance 1, even: the kurtosis is less than that of a Gaussian.
Vec3 noise(RandomStream& stream) {
    const double x = stream.uniform(), y = stream.uniform(), z = stream.uniform();
    return std::sqrt(12.0) * (Vec3(x, y, z) - Vec3::Constant(0.5));
}

/// Differences from far below the noise to far above, with noise that is common to the channels for the most part: over
/// many draws, the sums have the right mean, and their spread is what each of them tells in the mean square.
TEST(SplitSquare, TellsTheSquareAndItsDeviation) {
    constexpr int draws = 20000;
    Eigen::Matrix3d A, B;
    A << 1.0, 0.0, 0.0, 0.9, 0.2, 0.0, 0.8, 0.1, 0.1;
    B << 0.5, 0.0, 0.0, 0.5, 0.1, 0.0, -0.2, 0.0, 0.3;
    const Eigen::Matrix3d X = A * A.transpose(), Y = B * B.transpose();
    for (const double size : {0.0, 0.3, 1.0, 5.0}) {
        RandomStream stream(7, "halves");
        const Vec3 D = size * Vec3(1.0, -0.5, 0.25), other = size * Vec3(0.2, 0.2, 1.0);
        const double exact = D.squaredNorm() + other.squaredNorm();
        double mean = 0.0, spread = 0.0, told = 0.0;
        for (int i = 0; i < draws; ++i) {
            SplitSquare square;
            for (const Vec3& each : {D, other}) {
                square.add(each + A * noise(stream), X, each + B * noise(stream), Y);
            }
            mean += square.sum() / draws;
            spread += (square.sum() - exact) * (square.sum() - exact) / draws;
            told += square.deviation() * square.deviation() / draws;
        }
        const double variance = D.dot((X + Y) * D) + other.dot((X + Y) * other) + 2.0 * (X * Y).trace();
        EXPECT_NEAR(mean, exact, 4.5 * std::sqrt(variance / draws)) << size;
        // A mean of squares of products of two even variables is off by less than sqrt(8 / draws).
        EXPECT_NEAR(spread / variance, 1.0, 4.5 * std::sqrt(8.0 / draws)) << size;
        // Limited from below, which adds to the mean where the difference is small.
        EXPECT_GT(told / variance, 1.0 - 4.5 * std::sqrt(8.0 / draws)) << size;
        EXPECT_LT(told / variance, size < 1.0 ? 2.0 : 1.0 + 4.5 * std::sqrt(8.0 / draws)) << size;
    }
}

/// Halves that agree exactly tell the square exactly.
TEST(SplitSquare, WithoutNoiseItIsTheSquare) {
    SplitSquare square;
    const Vec3 D(3.0, 4.0, 12.0);
    square.add(D, Eigen::Matrix3d::Zero(), D, Eigen::Matrix3d::Zero());
    EXPECT_EQ(square.sum(), 169.0);
    EXPECT_EQ(square.deviation(), 0.0);
}

} // namespace
} // namespace difusa::split_square_test
