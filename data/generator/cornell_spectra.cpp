#include "cornell_spectra.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>

namespace scenes {

namespace {

// Reflectances at 400, 404, ..., 700 nm, as measured and published by the Cornell University Program of Computer
// Graphics ("Cornell Box Data", www.graphics.cornell.edu/online/box/data.html).
using Reflectances = std::array<double, 76>;

const Reflectances white{0.343, 0.445, 0.551, 0.624, 0.665, 0.687, 0.708, 0.723, 0.715, 0.710, 0.745, 0.758, 0.739,
                         0.767, 0.777, 0.765, 0.751, 0.745, 0.748, 0.729, 0.745, 0.757, 0.753, 0.750, 0.746, 0.747,
                         0.735, 0.732, 0.739, 0.734, 0.725, 0.721, 0.733, 0.725, 0.732, 0.743, 0.744, 0.748, 0.728,
                         0.716, 0.733, 0.726, 0.713, 0.740, 0.754, 0.764, 0.752, 0.736, 0.734, 0.741, 0.740, 0.732,
                         0.745, 0.755, 0.751, 0.744, 0.731, 0.733, 0.744, 0.731, 0.712, 0.708, 0.729, 0.730, 0.727,
                         0.707, 0.703, 0.729, 0.750, 0.760, 0.751, 0.739, 0.724, 0.730, 0.740, 0.737};

const Reflectances green{0.092, 0.096, 0.098, 0.097, 0.098, 0.095, 0.095, 0.097, 0.095, 0.094, 0.097, 0.098, 0.096,
                         0.101, 0.103, 0.104, 0.107, 0.109, 0.112, 0.115, 0.125, 0.140, 0.160, 0.187, 0.229, 0.285,
                         0.343, 0.390, 0.435, 0.464, 0.472, 0.476, 0.481, 0.462, 0.447, 0.441, 0.426, 0.406, 0.373,
                         0.347, 0.337, 0.314, 0.285, 0.277, 0.266, 0.250, 0.230, 0.207, 0.186, 0.171, 0.160, 0.148,
                         0.141, 0.136, 0.130, 0.126, 0.123, 0.121, 0.122, 0.119, 0.114, 0.115, 0.117, 0.117, 0.118,
                         0.120, 0.122, 0.128, 0.132, 0.139, 0.144, 0.146, 0.150, 0.152, 0.157, 0.159};

const Reflectances red{0.040, 0.046, 0.048, 0.053, 0.049, 0.050, 0.053, 0.055, 0.057, 0.056, 0.059, 0.057, 0.061,
                       0.061, 0.060, 0.062, 0.062, 0.062, 0.061, 0.062, 0.060, 0.059, 0.057, 0.058, 0.058, 0.058,
                       0.056, 0.055, 0.056, 0.059, 0.057, 0.055, 0.059, 0.059, 0.058, 0.059, 0.061, 0.061, 0.063,
                       0.063, 0.067, 0.068, 0.072, 0.080, 0.090, 0.099, 0.124, 0.154, 0.192, 0.255, 0.287, 0.349,
                       0.402, 0.443, 0.487, 0.513, 0.558, 0.584, 0.620, 0.606, 0.609, 0.651, 0.612, 0.610, 0.650,
                       0.638, 0.627, 0.620, 0.630, 0.628, 0.642, 0.639, 0.657, 0.639, 0.635, 0.642};

/// The area light's emission at 400, 500, 600 and 700 nm, from the same page.
const std::array<double, 4> lamp{0.0, 8.0, 15.6, 18.4};

double interpolate(const double* values, std::size_t last, double at) {
    const std::size_t i = std::min(static_cast<std::size_t>(at), last - 1);
    return values[i] + (values[i + 1] - values[i]) * (at - static_cast<double>(i));
}

/// A peak with different widths on either side; widths as reciprocals, in nm.
double lobe(double nm, double height, double peak, double below, double above) {
    const double t = (nm - peak) * (nm < peak ? below : above);
    return height * std::exp(-0.5 * t * t);
}

/// The CIE 1931 matching functions: eq. 4 of Wyman, Sloan and Shirley, "Simple Analytic Approximations to the CIE XYZ
/// Color Matching Functions", JCGT 2(2), 2013.
Vector matching_functions(double nm) {
    return {lobe(nm, 0.362, 442.0, 0.0624, 0.0374) + lobe(nm, 1.056, 599.8, 0.0264, 0.0323) -
                lobe(nm, 0.065, 501.1, 0.0490, 0.0382),
            lobe(nm, 0.821, 568.8, 0.0213, 0.0247) + lobe(nm, 0.286, 530.9, 0.0613, 0.0322),
            lobe(nm, 1.217, 437.0, 0.0845, 0.0278) + lobe(nm, 0.681, 459.0, 0.0385, 0.0725)};
}

Colour linear_srgb(const Vector& xyz) {
    return {3.2406 * xyz.x - 1.5372 * xyz.y - 0.4986 * xyz.z, -0.9689 * xyz.x + 1.8758 * xyz.y + 0.0415 * xyz.z,
            0.0557 * xyz.x - 0.2040 * xyz.y + 1.0570 * xyz.z};
}

/// The weighted means, by the trapezoidal rule in steps of 1 nm.
Colour reduce(const std::function<double(double)>& spectrum) {
    Colour sum, weight;
    for (int nm = 400; nm <= 700; ++nm) {
        const Colour sensitivity = linear_srgb(matching_functions(nm));
        const double part = nm == 400 || nm == 700 ? 0.5 : 1.0, value = spectrum(nm);
        weight = {weight.r + part * sensitivity.r, weight.g + part * sensitivity.g, weight.b + part * sensitivity.b};
        sum = {sum.r + part * sensitivity.r * value, sum.g + part * sensitivity.g * value,
               sum.b + part * sensitivity.b * value};
    }
    const auto rounded = [](double x) { return std::round(1e4 * x) / 1e4; };
    return {rounded(sum.r / weight.r), rounded(sum.g / weight.g), rounded(sum.b / weight.b)};
}

Colour reduce(const Reflectances& reflectances) {
    return reduce([&](double nm) { return interpolate(reflectances.data(), 75, (nm - 400.0) / 4.0); });
}

} // namespace

CornellColours cornell_colours() {
    return {reduce(white), reduce(green), reduce(red),
            reduce([](double nm) { return interpolate(lamp.data(), 3, (nm - 400.0) / 100.0); })};
}

} // namespace scenes
