// Tone curves, exposure, colours for numbers, and scales.
#include <difusa/core/colour.h>
#include <difusa/render/colour_map.h>
#include <difusa/render/tone_map.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

namespace difusa::tone_map_test {
namespace {

TEST(ToneMap, TheLinearCurveMultipliesAndCuts) {
    const Rgb shown = tone_map(Rgb(0.25, 1.0, -1.0), 2.0, ToneCurve::linear);
    EXPECT_EQ(shown[0], 0.5);
    EXPECT_EQ(shown[1], 1.0);
    EXPECT_EQ(shown[2], 0.0);
}

TEST(ToneMap, TheFilmicCurveGrowsFromZeroToOneAndIsLowerThanLinearWhereItIsBright) {
    EXPECT_EQ(filmic(0.0), 0.0);
    EXPECT_EQ(filmic(1e9), 1.0);
    for (double x = 1e-4; filmic(1.01 * x) < 1.0; x *= 1.01) {
        EXPECT_GT(filmic(1.01 * x), filmic(x));
    }
    EXPECT_LT(filmic(1.0), 1.0);
    EXPECT_EQ(tone_map(Rgb(0.1, 0.2, 0.3), 3.0, ToneCurve::filmic)[1], filmic(3.0 * 0.2));
}

TEST(ToneMap, UnderTheExposureNineteenTwentiethsAreAtMostNineTenths) {
    std::vector<float> luminances(1001); // 0 to 1000
    std::iota(luminances.begin(), luminances.end(), 0.0F);
    EXPECT_DOUBLE_EQ(exposure_for(luminances), 0.9 / 950.0);
    EXPECT_EQ(exposure_for({}), 1.0);
    EXPECT_EQ(exposure_for({0.0F, 0.0F}), 1.0);
    std::vector<float> spot(1000, 0.0F); // light on a thousandth of the picture
    spot[17] = 2.0F;
    EXPECT_EQ(exposure_for(spot), 0.45);
}

/// Oklab by the forward formulas of its author, which the colour map inverts.
Vec3 oklab(const Rgb& c) {
    const double l = std::cbrt(0.4122214708 * c[0] + 0.5363325363 * c[1] + 0.0514459929 * c[2]);
    const double m = std::cbrt(0.2119034982 * c[0] + 0.6806995451 * c[1] + 0.1073969566 * c[2]);
    const double s = std::cbrt(0.0883024619 * c[0] + 0.2817188376 * c[1] + 0.6299787005 * c[2]);
    return {0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s,
            1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s,
            0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s};
}

TEST(ColourMap, EqualStepsAreEqualStepsOfPerceivedColourAndBrighter) {
    constexpr int steps = 256;
    const double first = (oklab(colour_map(1.0 / steps)) - oklab(colour_map(0.0))).norm();
    for (int i = 0; i < steps; ++i) {
        const Rgb a = colour_map(static_cast<double>(i) / steps), b = colour_map((i + 1.0) / steps);
        EXPECT_GT(luminance(b), luminance(a));
        EXPECT_NEAR((oklab(b) - oklab(a)).norm(), first, 1e-4 * first); // the published matrices have ten digits
        EXPECT_TRUE((a >= 0.0).all() && (a <= 1.0).all()) << "out of gamut at " << i;
    }
    EXPECT_TRUE((colour_map(-3.0) == colour_map(0.0)).all());
    EXPECT_TRUE((colour_map(7.0) == colour_map(1.0)).all());
    EXPECT_TRUE((colour_map(1.0) <= 1.0).all());
}

TEST(ColourScale, PlacesValuesInProportionAndCutsBeyond) {
    const ColourScale scale{2.0, 6.0, false};
    EXPECT_EQ(scale.position(3.0), 0.25);
    EXPECT_EQ(scale.position(1.0), 0.0);
    EXPECT_EQ(scale.position(9.0), 1.0);
    const ColourScale log{0.01, 100.0, true};
    EXPECT_DOUBLE_EQ(log.position(1.0), 0.5);
    EXPECT_EQ(log.position(-1.0), 0.0);
    EXPECT_EQ(log.position(1e9), 1.0);
}

TEST(ColourScale, TicksAreRoundAndInside) {
    const auto near = [](const std::vector<double>& ticks, const std::vector<double>& wanted) {
        ASSERT_EQ(ticks.size(), wanted.size());
        for (std::size_t i = 0; i < ticks.size(); ++i) {
            EXPECT_DOUBLE_EQ(ticks[i], wanted[i]);
        }
    };
    near(ColourScale{0.0, 1.0, false}.ticks(), {0.0, 0.5, 1.0});
    near(ColourScale{0.03, 0.97, false}.ticks(), {0.2, 0.4, 0.6, 0.8});
    near(ColourScale{-2.0, 17.0, false}.ticks(), {0.0, 5.0, 10.0, 15.0});
    near(ColourScale{0.005, 200.0, true}.ticks(), {0.01, 0.1, 1.0, 10.0, 100.0});
    for (double high = 1.0001; high < 1e7; high *= 1.7) {
        for (const bool logarithmic : {false, true}) {
            const ColourScale scale{1.0, high, logarithmic};
            const std::vector<double> ticks = scale.ticks();
            EXPECT_GE(ticks.size(), 2U) << high;
            EXPECT_LE(ticks.size(), 21U) << high;
            for (const double tick : ticks) {
                EXPECT_GE(tick, 1.0 - 1e-9 * high);
                EXPECT_LE(tick, high * (1.0 + 1e-9));
            }
        }
    }
}

TEST(ColourScale, FollowsTheValues) {
    const ColourScale scale = scale_for({3.0F, -1.0F, 2.0F, std::numeric_limits<float>::quiet_NaN()}, false);
    EXPECT_EQ(scale.low, -1.0);
    EXPECT_EQ(scale.high, 3.0);
    const ColourScale log = scale_for({8.0F, 0.0F, -1.0F, 2.0F}, true);
    EXPECT_EQ(log.low, 2.0);
    EXPECT_EQ(log.high, 8.0);
    EXPECT_EQ(scale_for({1e-20F, 4.0F}, true).low, 4e-6);
    for (const float value : {0.0F, 1.0F, -5e10F}) { // a constant lies in the middle
        EXPECT_NEAR(scale_for({value, value, value}, false).position(static_cast<double>(value)), 0.5, 1e-14);
    }
    EXPECT_LT(scale_for({}, true).low, scale_for({}, true).high);
    std::vector<float> many(1001); // 0 to 1000, but for a few
    std::iota(many.begin(), many.end(), 0.0F);
    many[1000] = 1e9F;
    EXPECT_EQ(scale_for(many, false).low, 10.0);
    EXPECT_EQ(scale_for(many, false).high, 990.0);
}

} // namespace
} // namespace difusa::tone_map_test
