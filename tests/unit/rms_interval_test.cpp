// Means of squares from weighted points, and the intervals of their roots.
#include <difusa/core/random.h>
#include <difusa/radiosity/rms_interval.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace difusa {

namespace {

/// Weights leave no doubt about a constant: their sum is known.
TEST(RmsInterval, AConstantIsKnown) {
    RandomStream random(1, "weights");
    std::vector<double> weight(100), value(100, 4.0);
    double area = 0.0, squares = 0.0;
    for (double& each : weight) {
        each = random.uniform();
        area += each;
        squares += each * each;
    }
    const AreaMean mean = mean_over(area, weight, value);
    EXPECT_NEAR(mean.value, 4.0, 1e-14);
    EXPECT_NEAR(mean.deviation, 0.0, 1e-15);
    EXPECT_NEAR(mean.effective, area * area / squares, 1e-12 * mean.effective);
    const RmsEstimate root = root_of(mean);
    for (const double each : {root.low, root.rms, root.high}) {
        EXPECT_NEAR(each, 2.0, 1e-14);
    }
}

TEST(RmsInterval, NegativeMeansAreNoneOfSquares) {
    const AreaMean none{0.0, 0.3, 50.0, 0.1}, below{-5.0, 0.3, 50.0, 0.1};
    EXPECT_GE(root_of(none).high, std::sqrt(1.96 * 0.3));
    EXPECT_EQ(root_of(below).high, root_of(none).high);
    EXPECT_EQ(root_of(below).rms, 0.0);
    EXPECT_EQ(root_of(below).low, 0.0);
}

TEST(RmsInterval, MeansOfIndependentPartsAdd) {
    const AreaMean a{3.0, 0.3, 50.0, 0.1}, b{1.0, 0.4, 10.0, 0.0}, both = sum_of(a, b), alone = sum_of(a, AreaMean{});
    EXPECT_EQ(both.value, 4.0);
    EXPECT_NEAR(both.deviation, 0.5, 1e-15);
    EXPECT_EQ(both.largest, 0.1);
    EXPECT_NEAR(both.effective, 16.0 / (9.0 / 50.0 + 1.0 / 10.0), 1e-12);
    EXPECT_EQ(alone.value, a.value);
    EXPECT_EQ(alone.deviation, a.deviation);
    EXPECT_NEAR(alone.effective, a.effective, 1e-12);
}

/// Squares of 140 normally distributed numbers, of which the mean is 1: the upper end may be below 1 in 2.5 % of 4000
/// draws, 100 ± 10; 49 more have a probability of one in a million. The root of their mean has a deviation of
/// sqrt(2 / 140) / 2 = 6 %; the interval reaches at most four times as far in the median.
TEST(RmsInterval, HoldsForSquaresOfNormalNumbers) {
    RandomStream random(2, "values");
    constexpr std::size_t n = 140, draws = 4000;
    const std::vector<double> weight(n, 1.0 / n);
    std::size_t below = 0;
    std::vector<double> high;
    for (std::size_t draw = 0; draw < draws; ++draw) {
        std::vector<double> value(n);
        for (double& each : value) {
            const double x = std::sqrt(-2.0 * std::log(1.0 - random.uniform())) *
                             std::cos(2.0 * std::numbers::pi * random.uniform());
            each = x * x;
        }
        const RmsEstimate root = root_of(mean_over(1.0, weight, value));
        below += root.high < 1.0 ? 1 : 0;
        high.push_back(root.high);
        ASSERT_LE(root.low, root.rms);
        ASSERT_LE(root.rms, root.high);
    }
    EXPECT_LE(below, 149U);
    std::nth_element(high.begin(), high.begin() + draws / 2, high.end());
    EXPECT_LT(high[draws / 2], 1.24);
}

} // namespace

} // namespace difusa
