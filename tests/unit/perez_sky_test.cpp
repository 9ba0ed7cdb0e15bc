// The all-weather sky of Perez, Seals and Michalsky.
#include <difusa/core/error.h>
#include <difusa/scene/perez_sky.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace difusa::perez_sky_test {
namespace {

constexpr double pi = std::numbers::pi, degree = pi / 180.0;

Vec3 at(double elevation, double azimuth) {
    return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation)};
}

TEST(PerezSky, WithoutGradationIsUniform) {
    const PerezSky sky({}, Vec3::UnitZ(), at(0.5, 1.0), Rgb(pi, 2.0 * pi, 3.0 * pi));
    for (const double elevation : {0.0, 0.3, 1.0, 0.5 * pi}) {
        EXPECT_LE((sky.radiance(at(elevation, 2.0)) - Rgb(1, 2, 3)).abs().maxCoeff(), 1e-6) << elevation;
    }
    EXPECT_TRUE((sky.radiance(-Vec3::UnitZ()) == 0.0).all());
    EXPECT_FALSE(sky.is_grey());
}

/// Equations 1 and 2 of 1990.
TEST(PerezSky, ClearnessAndBrightnessAreThoseOfTheWeather) {
    const PerezWeather overcast = perez_weather(0.0, 136.7, 0.0, 11.0);
    EXPECT_DOUBLE_EQ(overcast.clearness, 1.0);
    EXPECT_NEAR(overcast.brightness, 0.1 / (1.0 + 0.15 * std::pow(93.885, -1.253)), 1e-15);
    const PerezWeather clear = perez_weather(800.0, 100.0, 60.0 * degree, 11.0);
    const double cubed = 1.041 * std::pow(60.0 * degree, 3);
    EXPECT_NEAR(clear.clearness, (9.0 + cubed) / (1.0 + cubed), 1e-14);
    // About 120 lm/W of a sky, about 100 of a high sun: the last rows of table 4.
    const double water = std::exp(0.07 * 11.0 - 0.075);
    EXPECT_NEAR(perez_weather(900.0, 80.0, 0.0, 11.0).diffuse_efficacy,
                152.23 + 0.35 * water - 45.27 - 7.98 * std::log(perez_weather(900.0, 80.0, 0.0, 11.0).brightness),
                1e-12);
    EXPECT_GE(perez_weather(1.0, 80.0, 0.5 * pi, 11.0).direct_efficacy, 0.0);
}

/// Table 1 and equations 6 to 8 of 1993, by hand.
TEST(PerezSky, ShapesAreThoseOfTheTable) {
    const PerezShape clear = perez_shape(7.0, 0.0, 0.0);
    EXPECT_DOUBLE_EQ(clear.a, -1.05);
    EXPECT_DOUBLE_EQ(clear.b, -0.325);
    EXPECT_DOUBLE_EQ(clear.c, 31.0625);
    EXPECT_DOUBLE_EQ(clear.d, -7.2312);
    EXPECT_DOUBLE_EQ(clear.e, 1.5);
    const PerezShape middle = perez_shape(2.0, 0.1, 1.0);
    EXPECT_NEAR(middle.a, -0.6 - 0.3566 + 0.1 * (-2.5 + 2.325), 1e-15);
    EXPECT_NEAR(middle.c, 21.0 - 4.7656 + 0.1 * (-21.5906 + 7.2492), 1e-14);
    const PerezShape overcast = perez_shape(1.0, 0.2, 0.5);
    EXPECT_NEAR(overcast.c, std::exp(std::pow(0.2 * (2.8 + 0.6004 * 0.5), 1.2375)) - 1.0, 1e-14);
    EXPECT_NEAR(overcast.d, -std::exp(0.2 * (1.8734 + 0.6297 * 0.5)) + 0.9738 + 0.2 * 0.2809, 1e-14);
    EXPECT_EQ(perez_shape(1.065, 0.2, 0.5).a, perez_shape(1.1, 0.2, 0.5).a) << "ranges begin at their lower ends";
    EXPECT_NE(perez_shape(1.064, 0.2, 0.5).a, perez_shape(1.065, 0.2, 0.5).a);
}

/// The integral over the hemisphere by a midpoint rule of 400 x 400, whose own error is below 1e-4 of smooth shapes.
TEST(PerezSky, GivesLevelGroundItsIrradiance) {
    for (const double direct : {0.0, 100.0, 400.0, 900.0}) {
        const double elevation = 40.0 * degree;
        const PerezWeather weather = perez_weather(direct, 120.0, 0.5 * pi - elevation, 11.0);
        const PerezSky sky(weather.shape, Vec3::UnitZ(), at(elevation, 0.3), Rgb::Constant(120.0));
        constexpr int n = 400;
        double sum = 0.0;
        for (int i = 0; i < n; ++i) {
            const double height = 0.5 * pi * (i + 0.5) / n;
            for (int j = 0; j < n; ++j) {
                sum += sky.radiance(at(height, 2.0 * pi * (j + 0.5) / n))[0] * std::sin(height) * std::cos(height);
            }
        }
        EXPECT_NEAR(sum * pi * pi / (n * n), 120.0, 0.1) << direct;
    }
}

TEST(PerezSky, IsBrightestAroundTheSunAndSymmetric) {
    const double elevation = 40.0 * degree;
    const PerezWeather weather = perez_weather(800.0, 100.0, 50.0 * degree, 11.0);
    const PerezSky sky(weather.shape, Vec3::UnitZ(), at(elevation, 0.0), Rgb::Constant(100.0));
    EXPECT_GT(sky.radiance(at(elevation, 0.0))[0], 5.0 * sky.radiance(at(elevation, pi))[0]);
    for (const double azimuth : {0.2, 1.0, 3.0}) {
        EXPECT_NEAR(sky.radiance(at(0.7, azimuth))[0] / sky.radiance(at(0.7, -azimuth))[0], 1.0, 1e-12);
    }
    // The ratio of two radiances is that of the formula.
    const auto& s = weather.shape;
    const auto relative = [&](double zeta, double gamma) {
        return (1.0 + s.a * std::exp(s.b / std::cos(zeta))) *
               (1.0 + s.c * std::exp(s.d * gamma) + s.e * std::pow(std::cos(gamma), 2));
    };
    EXPECT_NEAR(sky.radiance(at(elevation, 0.0))[0] / sky.radiance(Vec3::UnitZ())[0],
                relative(50.0 * degree, 0.0) / relative(0.0, 50.0 * degree), 1e-6);
}

TEST(PerezSky, RefusesWhatCannotBe) {
    EXPECT_THROW(perez_weather(100.0, 0.0, 1.0, 11.0), UsageError);
    EXPECT_THROW(perez_weather(-1.0, 10.0, 1.0, 11.0), UsageError);
    EXPECT_THROW(perez_weather(1.0, 10.0, 2.0, 11.0), UsageError);
    EXPECT_THROW(perez_weather(1.0, 10.0, 1.0, 100.0), UsageError);
    EXPECT_THROW(PerezSky({}, Vec3::UnitZ(), -Vec3::UnitZ(), Rgb::Ones()), std::invalid_argument);
}

} // namespace
} // namespace difusa::perez_sky_test
