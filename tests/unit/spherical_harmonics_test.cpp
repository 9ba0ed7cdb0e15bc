#include <difusa/algebra/spherical_harmonics.h>
#include <difusa/core/frame.h>
#include <difusa/core/random.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace difusa::spherical_harmonics_test {
namespace {

constexpr int order = 12;

Vec3 random_direction(RandomStream& stream) {
    const double z = 2.0 * stream.uniform() - 1.0, angle = 2.0 * std::numbers::pi * stream.uniform();
    const double r = std::sqrt(1.0 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
}

/// The first nine in closed form.
TEST(SphericalHarmonics, AreThoseOfTheTables) {
    const SphericalHarmonics harmonics(2);
    std::vector<double> Y(harmonics.count());
    RandomStream stream(1, "harmonics");
    for (int i = 0; i < 20; ++i) {
        const Vec3 d = random_direction(stream);
        const double x = d.x(), y = d.y(), z = d.z(), pi = std::numbers::pi;
        harmonics.at(d, Y);
        const double expected[] = {std::sqrt(0.25 / pi),
                                   std::sqrt(0.75 / pi) * y,
                                   std::sqrt(0.75 / pi) * z,
                                   std::sqrt(0.75 / pi) * x,
                                   std::sqrt(3.75 / pi) * x * y,
                                   std::sqrt(3.75 / pi) * y * z,
                                   std::sqrt(0.3125 / pi) * (3.0 * z * z - 1.0),
                                   std::sqrt(3.75 / pi) * x * z,
                                   std::sqrt(0.9375 / pi) * (x * x - y * y)};
        for (std::size_t k = 0; k < 9; ++k) {
            EXPECT_NEAR(Y[k], expected[k], 1e-14) << k;
        }
    }
}

/// sum_m Y_lm(a) Y_lm(b) = (2 l + 1) / (4 pi) P_l(a·b).
TEST(SphericalHarmonics, ObeyTheAdditionTheorem) {
    const SphericalHarmonics harmonics(order);
    std::vector<double> A(harmonics.count()), B(harmonics.count());
    RandomStream stream(2, "harmonics");
    for (int i = 0; i < 20; ++i) {
        const Vec3 a = random_direction(stream), b = random_direction(stream);
        harmonics.at(a, A);
        harmonics.at(b, B);
        for (int l = 0; l <= order; ++l) {
            double sum = 0.0;
            for (int m = -l; m <= l; ++m) {
                sum += A[SphericalHarmonics::number(l, m)] * B[SphericalHarmonics::number(l, m)];
            }
            EXPECT_NEAR(sum,
                        (2.0 * l + 1.0) / (4.0 * std::numbers::pi) * std::legendre(static_cast<unsigned>(l), a.dot(b)),
                        1e-12)
                << l;
        }
    }
}

/// A function that is turned has the values of the function at the directions turned back, and its coefficients are
/// turned back by the transpose.
TEST(SphericalHarmonics, AreRotated) {
    const SphericalHarmonics harmonics(order);
    RandomStream stream(3, "harmonics");
    const auto count = static_cast<Eigen::Index>(harmonics.count());
    Values c(count, 2), turned(count, 2), back(count, 2);
    for (Eigen::Index k = 0; k < c.size(); ++k) {
        c.data()[k] = stream.uniform() - 0.5;
    }
    const Eigen::Matrix3d R = frame_of(random_direction(stream)) * frame_of(random_direction(stream));
    const SphericalHarmonics::Rotation rotation = harmonics.rotation(R);
    SphericalHarmonics::rotate(rotation, c, turned);
    std::vector<double> Y(harmonics.count());
    for (int i = 0; i < 20; ++i) {
        const Vec3 d = random_direction(stream);
        harmonics.at(d, Y);
        const Eigen::RowVectorXd there = Eigen::Map<const Eigen::RowVectorXd>(Y.data(), count) * turned;
        harmonics.at(R.transpose() * d, Y);
        const Eigen::RowVectorXd here = Eigen::Map<const Eigen::RowVectorXd>(Y.data(), count) * c;
        EXPECT_LT((there - here).norm(), 1e-11);
    }
    SphericalHarmonics::rotate_back(rotation, turned, back);
    EXPECT_LT((back - c).norm(), 1e-11);
}

} // namespace
} // namespace difusa::spherical_harmonics_test
