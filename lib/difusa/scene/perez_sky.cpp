#include <difusa/scene/perez_sky.h>

#include <difusa/core/colour.h>
#include <difusa/core/error.h>
#include <difusa/scene/sky_quadrature.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>

namespace difusa {

namespace {

constexpr std::size_t weathers = 8;

/// Upper ends of the ranges of clearness (1990, table 1); the last one has none.
constexpr std::array<double, weathers - 1> clearness_below{1.065, 1.230, 1.500, 1.950, 2.800, 4.500, 6.200};

using FourOf = std::array<double, 4>;

/// Table 1 of 1993: a, b, c, d, e of each range.
constexpr std::array<std::array<FourOf, 5>, weathers> perez_table{{{{{1.3525, -0.2576, -0.2690, -1.4366},
                                                                     {-0.7670, 0.0007, 1.2734, -0.1233},
                                                                     {2.8000, 0.6004, 1.2375, 1.0000},
                                                                     {1.8734, 0.6297, 0.9738, 0.2809},
                                                                     {0.0356, -0.1246, -0.5718, 0.9938}}},
                                                                   {{{-1.2219, -0.7730, 1.4148, 1.1016},
                                                                     {-0.2054, 0.0367, -3.9128, 0.9156},
                                                                     {6.9750, 0.1774, 6.4477, -0.1239},
                                                                     {-1.5798, -0.5081, -1.7812, 0.1080},
                                                                     {0.2624, 0.0672, -0.2190, -0.4285}}},
                                                                   {{{-1.1000, -0.2515, 0.8952, 0.0156},
                                                                     {0.2782, -0.1812, -4.5000, 1.1766},
                                                                     {24.7219, -13.0812, -37.7000, 34.8438},
                                                                     {-5.0000, 1.5218, 3.9229, -2.6204},
                                                                     {-0.0156, 0.1597, 0.4199, -0.5562}}},
                                                                   {{{-0.5484, -0.6654, -0.2672, 0.7117},
                                                                     {0.7234, -0.6219, -5.6812, 2.6297},
                                                                     {33.3389, -18.3000, -62.2500, 52.0781},
                                                                     {-3.5000, 0.0016, 1.1477, 0.1062},
                                                                     {0.4659, -0.3296, -0.0876, -0.0329}}},
                                                                   {{{-0.6000, -0.3566, -2.5000, 2.3250},
                                                                     {0.2937, 0.0496, -5.6812, 1.8415},
                                                                     {21.0000, -4.7656, -21.5906, 7.2492},
                                                                     {-3.5000, -0.1554, 1.4062, 0.3988},
                                                                     {0.0032, 0.0766, -0.0656, -0.1294}}},
                                                                   {{{-1.0156, -0.3670, 1.0078, 1.4051},
                                                                     {0.2875, -0.5328, -3.8500, 3.3750},
                                                                     {14.0000, -0.9999, -7.1406, 7.5469},
                                                                     {-3.4000, -0.1078, -1.0750, 1.5702},
                                                                     {-0.0672, 0.4016, 0.3017, -0.4844}}},
                                                                   {{{-1.0000, 0.0211, 0.5025, -0.5119},
                                                                     {-0.3000, 0.1922, 0.7023, -1.6317},
                                                                     {19.0000, -5.0000, 1.2438, -1.9094},
                                                                     {-4.0000, 0.0250, 0.3844, 0.2656},
                                                                     {1.0468, -0.3788, -2.4517, 1.4656}}},
                                                                   {{{-1.0500, 0.0289, 0.4260, 0.3590},
                                                                     {-0.3250, 0.1156, 0.7781, 0.0025},
                                                                     {31.0625, -14.5000, -46.1148, 55.3750},
                                                                     {-7.2312, 0.4050, 13.3500, 0.6234},
                                                                     {1.5000, -0.6426, 1.8564, 0.5636}}}}};

/// Table 4 of 1990: luminous efficacies of diffuse and of direct light.
constexpr std::array<FourOf, weathers> diffuse_efficacies{{{97.24, -0.46, 12.00, -8.91},
                                                           {107.22, 1.15, 0.59, -3.95},
                                                           {104.97, 2.96, -5.53, -8.77},
                                                           {102.39, 5.59, -13.95, -13.90},
                                                           {100.71, 5.94, -22.75, -23.74},
                                                           {106.42, 3.83, -36.15, -28.83},
                                                           {141.88, 1.90, -53.24, -14.03},
                                                           {152.23, 0.35, -45.27, -7.98}}};
constexpr std::array<FourOf, weathers> direct_efficacies{{{57.20, -4.55, -2.98, 117.12},
                                                          {98.99, -3.46, -1.21, 12.38},
                                                          {109.83, -4.90, -1.71, -8.81},
                                                          {110.34, -5.84, -1.99, -4.56},
                                                          {106.36, -3.97, -1.75, -6.16},
                                                          {107.19, -1.25, -1.51, -26.73},
                                                          {105.75, 0.77, -1.26, -34.44},
                                                          {101.18, 1.58, -1.10, -8.29}}};

std::size_t range_of(double clearness) {
    return static_cast<std::size_t>(std::upper_bound(clearness_below.begin(), clearness_below.end(), clearness) -
                                    clearness_below.begin());
}

/// F. Kasten, "A new table and approximation formula for the relative optical air mass" (1966).
double kasten_air_mass(double zenith) {
    const double degrees = zenith * 180.0 / std::numbers::pi;
    return 1.0 / (std::cos(zenith) + 0.15 * std::pow(93.885 - degrees, -1.253));
}

} // namespace

double PerezShape::relative(double cos_zeta, double gamma) const {
    constexpr double horizon = 0.01;
    const double cosine = std::cos(gamma);
    return std::max(0.0, (1.0 + a * std::exp(b / std::max(cos_zeta, horizon))) *
                             (1.0 + c * std::exp(d * gamma) + e * cosine * cosine));
}

PerezShape perez_shape(double clearness, double brightness, double zenith) {
    const std::size_t range = range_of(clearness);
    const std::array<FourOf, 5>& table = perez_table[range];
    const auto linear = [&](std::size_t row) {
        const FourOf& x = table[row];
        return x[0] + x[1] * zenith + brightness * (x[2] + x[3] * zenith);
    };
    PerezShape shape{linear(0), linear(1), linear(2), linear(3), linear(4)};
    if (range == 0) {
        const FourOf &c = table[2], &d = table[3];
        shape.c = std::exp(std::pow(brightness * (c[0] + c[1] * zenith), c[2])) - c[3];
        shape.d = -std::exp(brightness * (d[0] + d[1] * zenith)) + d[2] + brightness * d[3];
    }
    return shape;
}

PerezWeather perez_weather(double direct, double diffuse, double zenith, double dew_point) {
    if (!(diffuse > 0.0) || !std::isfinite(diffuse) || !(direct >= 0.0) || !std::isfinite(direct) ||
        !(zenith >= 0.0 && zenith <= 0.5 * std::numbers::pi) || !(dew_point >= -90.0 && dew_point <= 60.0)) {
        throw UsageError("a Perez sky needs a diffuse irradiance above 0, a direct one of at least 0, a sun that is "
                         "not below the horizon, and a dew point from -90 to 60 degrees");
    }
    constexpr double extraterrestrial = 1367.0;
    const double cubed = 1.041 * zenith * zenith * zenith;
    PerezWeather weather;
    weather.clearness = ((diffuse + direct) / diffuse + cubed) / (1.0 + cubed);
    weather.brightness = diffuse * kasten_air_mass(zenith) / extraterrestrial;
    const bool sparse = weather.clearness > 1.065 && weather.clearness < 2.8;
    weather.shape =
        perez_shape(weather.clearness, sparse ? std::max(weather.brightness, 0.2) : weather.brightness, zenith);
    const double water = std::exp(0.07 * dew_point - 0.075); // cm
    const FourOf &soft = diffuse_efficacies[range_of(weather.clearness)],
                 &sharp = direct_efficacies[range_of(weather.clearness)];
    weather.diffuse_efficacy =
        soft[0] + soft[1] * water + soft[2] * std::cos(zenith) + soft[3] * std::log(weather.brightness);
    weather.direct_efficacy = std::max(0.0, sharp[0] + sharp[1] * water + sharp[2] * std::exp(5.73 * zenith - 5.0) +
                                                sharp[3] * weather.brightness);
    return weather;
}

PerezSky::PerezSky(const PerezShape& shape, const Vec3& up, const Vec3& sun, const Rgb& irradiance)
    : shape_(shape), up_(up), sun_(sun) {
    if (!(up.dot(sun) >= -1e-12)) {
        throw std::invalid_argument("the sun of a Perez sky is not below the horizon");
    }
    constexpr std::size_t nodes = 64;
    scale_ =
        irradiance / level_irradiance(up, sun, nodes, [this](const Vec3& towards) { return radiance(towards)[0]; });
}

Rgb PerezSky::radiance(const Vec3& towards) const {
    const double cosine = towards.dot(up_);
    if (cosine < 0.0) {
        return Rgb::Zero();
    }
    return shape_.relative(cosine, std::acos(std::clamp(towards.dot(sun_), -1.0, 1.0))) * scale_;
}

bool PerezSky::is_grey() const {
    return equal_channels(scale_);
}

} // namespace difusa
