#include <difusa/core/error.h>
#include <difusa/study/metrics.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace difusa::metrics_test {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

/// Midpoints of n equal cells of [0,1].
std::vector<double> midpoints(int n) {
    std::vector<double> x;
    for (int i = 0; i < n; ++i) {
        x.push_back((i + 0.5) / n);
    }
    return x;
}

TEST(Metrics, ConstantErrorIsItsOwnNorm) {
    const std::vector<double> f{3, 3, 3, 3}, g{4, 4, 4, 4}, weight{0.5, 1, 2, 0.5};
    const ErrorNorms norms = error_norms(f, g, weight);
    EXPECT_EQ(norms.area, 4.0);
    for (const Norm& norm : {norms.l1, norms.l2, norms.linf, norms.percentile95, norms.percentile99}) {
        EXPECT_EQ(norm.error, 1.0);
        EXPECT_EQ(norm.reference, 4.0);
        EXPECT_EQ(norm.relative(), 0.25);
    }
    EXPECT_EQ(norms.bias.error, -1.0);
    EXPECT_EQ(norms.bias.relative(), -0.25);
    EXPECT_EQ(norms.integral.error, -4.0);
    EXPECT_EQ(norms.integral.reference, 16.0);
    EXPECT_EQ(norms.integral.relative(), -0.25);
}

TEST(Metrics, LinearErrorByMidpointsHasClosedForms) {
    // e = x by the midpoint rule: exact for ∫ x; ∫ x² is short by 1/(12 n²).
    const int n = 1000;
    const std::vector<double> e = midpoints(n), weight(static_cast<std::size_t>(n), 2.0 / n);
    std::vector<double> f, g;
    for (const double x : e) {
        g.push_back(-1.0); // sums f - g = x without rounding to speak of
        f.push_back(x - 1.0);
    }
    const ErrorNorms norms = error_norms(f, g, weight);
    const double rounding = 4 * n * eps; // of the weights' sum, at most
    EXPECT_NEAR(norms.area, 2.0, 2.0 * rounding);
    EXPECT_NEAR(norms.l1.error, 0.5, rounding);
    EXPECT_NEAR(norms.bias.error, 0.5, rounding);
    EXPECT_NEAR(norms.integral.error, 1.0, rounding);
    EXPECT_NEAR(norms.l2.error, std::sqrt(1.0 / 3.0 - 1.0 / (12.0 * n * n)), rounding);
    EXPECT_NEAR(norms.linf.error, 1.0 - 0.5 / n, eps);
    // The 950th of the 1000 cells completes 95 % of the area.
    EXPECT_NEAR(norms.percentile95.error, 949.5 / n, eps);
    EXPECT_NEAR(norms.percentile99.error, 989.5 / n, eps);
}

TEST(Metrics, PercentilesGoByAreaNotByNumberOfPoints) {
    // One point of 96 % of the area against a hundred that share the rest.
    std::vector<double> f{1.0}, weight{96.0};
    for (int i = 0; i < 100; ++i) {
        f.push_back(10.0 + i);
        weight.push_back(0.04);
    }
    const std::vector<double> g(f.size(), 0.0);
    const ErrorNorms norms = error_norms(f, g, weight);
    EXPECT_EQ(norms.percentile95.error, 1.0);
    EXPECT_EQ(norms.percentile99.error, 10.0 + 74.0); // 96 + 75 · 0.04 = 99
    EXPECT_EQ(norms.linf.error, 109.0);
}

TEST(Metrics, SignsCancelInTheBiasOnly) {
    const int n = 64;
    std::vector<double> f, g(static_cast<std::size_t>(n), 2.0), weight(static_cast<std::size_t>(n), 1.0);
    for (int i = 0; i < n; ++i) {
        f.push_back(i % 2 == 0 ? 3.0 : 1.0);
    }
    const ErrorNorms norms = error_norms(f, g, weight);
    EXPECT_EQ(norms.bias.error, 0.0);
    EXPECT_EQ(norms.integral.error, 0.0);
    EXPECT_EQ(norms.integral.relative(), 0.0);
    EXPECT_EQ(norms.l1.error, 1.0);
    EXPECT_EQ(norms.l2.error, 1.0);
}

TEST(Metrics, ReferenceOfTheIntegralIsItsIntegralAndOfTheBiasItsMeanMagnitude) {
    const std::vector<double> f{2, 0}, g{1, -3}, weight{1, 1};
    const ErrorNorms norms = error_norms(f, g, weight);
    EXPECT_EQ(norms.bias.error, 2.0);
    EXPECT_EQ(norms.bias.reference, 2.0);
    EXPECT_EQ(norms.integral.error, 4.0);
    EXPECT_EQ(norms.integral.reference, 2.0);
    EXPECT_EQ(norms.integral.relative(), 2.0);
}

TEST(Metrics, WithoutAReferenceThereIsNoRelativeErrorUnlessThereIsNoError) {
    const std::vector<double> zero{0, 0}, one{1, 1}, weight{1, 1};
    const ErrorNorms some = error_norms(one, zero, weight);
    EXPECT_EQ(some.l2.error, 1.0);
    EXPECT_FALSE(some.l2.relative().has_value());
    EXPECT_FALSE(some.integral.relative().has_value());
    const ErrorNorms no = error_norms(zero, zero, weight);
    EXPECT_EQ(no.l2.relative(), 0.0);
    EXPECT_EQ(no.linf.relative(), 0.0);
}

TEST(Metrics, PointsWithoutAreaCountForTheLargestErrorOnly) {
    const std::vector<double> f{1, 5}, g{0, 1}, weight{1, 0};
    const ErrorNorms norms = error_norms(f, g, weight);
    EXPECT_EQ(norms.linf.error, 4.0);
    EXPECT_EQ(norms.l1.error, 1.0);
    EXPECT_EQ(norms.percentile99.error, 1.0);
    const ErrorNorms bare = error_norms(f, g, std::vector<double>{0, 0});
    EXPECT_EQ(bare.linf.error, 4.0);
    EXPECT_EQ(bare.l2.error, 0.0);
}

TEST(Metrics, ScalesByPowersOfTwoChangeNoBit) {
    const std::vector<double> x = midpoints(97);
    const auto norms = [&](int value_exponent, int area_exponent) {
        std::vector<double> f, g, weight;
        for (const double t : x) {
            f.push_back(std::ldexp(std::sin(7 * t), value_exponent));
            g.push_back(std::ldexp(std::cos(5 * t), value_exponent));
            weight.push_back(std::ldexp(1.0 + t * t, area_exponent));
        }
        return error_norms(f, g, weight);
    };
    const ErrorNorms plain = norms(0, 0);
    for (const int exponent : {-1000, -600, 600, 1000}) { // squares and cubes of these are no doubles
        for (const ErrorNorms& scaled : {norms(exponent, 0), norms(0, exponent)}) {
            EXPECT_EQ(scaled.l1.relative(), plain.l1.relative());
            EXPECT_EQ(scaled.l2.relative(), plain.l2.relative());
            EXPECT_EQ(scaled.linf.relative(), plain.linf.relative());
            EXPECT_EQ(scaled.percentile95.relative(), plain.percentile95.relative());
            EXPECT_EQ(scaled.percentile99.relative(), plain.percentile99.relative());
            EXPECT_EQ(scaled.bias.relative(), plain.bias.relative());
            EXPECT_EQ(scaled.integral.relative(), plain.integral.relative());
        }
    }
}

TEST(Metrics, ChannelsTogetherAreSheetsSideBySide) {
    Values f(3, 3), g(3, 3);
    f << 1, 2, 3, 4, 5, 6, 7, 8, 9;
    g << 1, 1, 1, 2, 2, 2, 3, 3, 3;
    const std::vector<double> weight{1, 2, 1};
    const FieldNorms norms = field_norms(f, g, weight, true);
    ASSERT_EQ(norms.channel.size(), 3u);
    const Values e = f - g;
    double sum = 0.0, square = 0.0;
    for (int p = 0; p < 3; ++p) {
        sum += weight[static_cast<std::size_t>(p)] * e.row(p).sum() / 12.0;
        square += weight[static_cast<std::size_t>(p)] * e.row(p).squaredNorm() / 12.0;
    }
    EXPECT_NEAR(norms.all.l1.error, sum, 16 * eps * sum);
    EXPECT_NEAR(norms.all.l2.error, std::sqrt(square), 16 * eps * std::sqrt(square));
    EXPECT_EQ(norms.all.linf.error, 6.0);
    EXPECT_EQ(norms.channel[0].linf.error, 4.0);
    EXPECT_EQ(norms.channel[2].linf.reference, 3.0);
    // The luminance of grey is its value.
    ASSERT_TRUE(norms.weighted.has_value());
    EXPECT_NEAR(norms.weighted->linf.reference, 3.0, 8 * eps);
    EXPECT_NEAR(norms.weighted->linf.error, 0.2126 * 4 + 0.7152 * 5 + 0.0722 * 6, 32 * eps);
    EXPECT_FALSE(field_norms(f, g, weight, false).weighted.has_value());
}

TEST(Metrics, NumbersThatAreNoneAreRefused) {
    const std::vector<double> nan{std::numeric_limits<double>::quiet_NaN()}, one{1.0}, minus{-1.0};
    EXPECT_THROW(error_norms(nan, one, one), InternalError);
    EXPECT_THROW(error_norms(one, nan, one), InternalError);
    EXPECT_THROW(error_norms(one, one, nan), InternalError);
    EXPECT_THROW(error_norms(one, one, minus), InternalError);
    EXPECT_THROW(error_norms(one, one, std::vector<double>{1, 1}), InternalError);
}

TEST(ConvergenceOrder, PowersHaveTheirExponent) {
    const std::vector<double> h{1.0, 0.5, 0.3, 0.01};
    for (const double p : {1.0, 2.0, 0.5, -1.0}) {
        std::vector<double> error;
        for (const double x : h) {
            error.push_back(3e-9 * std::pow(x, p));
        }
        EXPECT_NEAR(convergence_order(h, error), p, 64 * eps);
    }
}

TEST(ConvergenceOrder, IsTheLeastSquaresSlope) {
    // log h = 0, -1, -2; log error = 0, -1, -5: the slope is (0 - (-5)) / 2.
    const double e = std::numbers::e;
    EXPECT_NEAR(
        convergence_order(std::vector<double>{1, 1 / e, 1 / (e * e)}, std::vector<double>{1, 1 / e, std::exp(-5.0)}),
        2.5, 32 * eps);
}

TEST(ConvergenceOrder, RefusesWhatHasNone) {
    const auto order = [](std::vector<double> h, std::vector<double> error) { return convergence_order(h, error); };
    EXPECT_THROW(order({1, 0.5}, {1, 0}), UsageError);
    EXPECT_THROW(order({1, 0}, {1, 0.5}), UsageError);
    EXPECT_THROW(order({1, 1}, {1, 0.5}), UsageError);
    EXPECT_THROW(order({1}, {1}), UsageError);
    EXPECT_THROW(order({}, {}), UsageError);
    EXPECT_THROW(order({1, 0.5}, {1, std::numeric_limits<double>::infinity()}), UsageError);
}

} // namespace
} // namespace difusa::metrics_test
