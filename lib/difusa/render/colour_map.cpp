#include <difusa/render/colour_map.h>

#include <difusa/core/round_values.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>

namespace difusa {

namespace {

/// Linear sRGB of an Oklab colour, with the author's coefficients (Ottosson, "A perceptual color space for image
/// processing", 2020).
Rgb from_oklab(double L, double a, double b) {
    const auto cube = [](double x) { return x * x * x; };
    const double l = cube(L + 0.3963377774 * a + 0.2158037573 * b);
    const double m = cube(L - 0.1055613458 * a - 0.0638541728 * b);
    const double s = cube(L - 0.0894841775 * a - 1.2914855480 * b);
    return {4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
            -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
            -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s};
}

constexpr double outside = 0.01; ///< share of the values beyond either end of a scale

} // namespace

Rgb colour_map(double t) {
    t = std::clamp(t, 0.0, 1.0);
    const double hue = (310.0 + (105.0 - 310.0) * t) * std::numbers::pi / 180.0;
    constexpr double chroma = 0.098;
    return from_oklab(0.25 + (0.92 - 0.25) * t, chroma * std::cos(hue), chroma * std::sin(hue));
}

double ColourScale::position(double value) const {
    if (logarithmic) {
        return value > low ? std::min(1.0, std::log(value / low) / std::log(high / low)) : 0.0;
    }
    return std::clamp((value - low) / (high - low), 0.0, 1.0);
}

std::vector<double> ColourScale::ticks() const {
    if (logarithmic) {
        std::vector<double> values;
        for (const double exponent : multiples_in(std::log10(low), std::log10(high), 1.0)) {
            values.push_back(std::pow(10.0, exponent));
        }
        if (values.size() > 1) {
            return values;
        }
    }
    const double power = power_of_ten_below((high - low) / 2.0);
    for (const double factor : {5.0, 2.0}) { // the largest step that gives three ticks
        if (const auto values = multiples_in(low, high, factor * power); values.size() >= 3) {
            return values;
        }
    }
    return multiples_in(low, high, power);
}

ColourScale scale_for(const std::vector<float>& values, bool logarithmic) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    std::vector<float> counted;
    std::copy_if(values.begin(), values.end(), std::back_inserter(counted),
                 [&](float value) { return std::isfinite(value) && (!logarithmic || value > 0.0F); });
    if (!counted.empty()) {
        const auto percentile = [&](double share) {
            const auto at = counted.begin() + std::lround(share * static_cast<double>(counted.size() - 1));
            std::nth_element(counted.begin(), at, counted.end());
            return static_cast<double>(*at);
        };
        low = percentile(outside);
        high = percentile(1.0 - outside);
    }
    if (!(low <= high)) {
        return {logarithmic ? 0.1 : 0.0, 1.0, logarithmic};
    }
    if (logarithmic) {
        low = std::max(low, 1e-6 * high);
    }
    const double size = std::max(std::abs(low), std::abs(high));
    if (high - low <= 1e-5 * size || size == 0.0) { // single precision has seven digits
        const double middle = 0.5 * (low + high), room = size > 0.0 ? 0.1 * size : 1.0;
        return {middle - room, middle + room, logarithmic};
    }
    return {low, high, logarithmic};
}

} // namespace difusa
