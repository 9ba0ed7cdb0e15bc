// Angles in loops over many vectors.
#pragma once

#include <cmath>
#include <numbers>

namespace difusa {

/// std::atan2(sine, cosine) for sine >= 0, not both 0, to within 4 units in the last place: the angle in [0, pi]
/// between vectors whose cross product has the length `sine` and whose scalar product is `cosine`. It neither calls nor
/// branches, so that loops become vectors (compiled with -O3 -fno-trapping-math).
inline double angle_between(double sine, double cosine) {
    constexpr double eighth = 0x1.a827999fcef32p-2; // tan(pi / 8)
    const double flat = std::abs(cosine);
    const double less = sine < flat ? sine : flat, more = sine < flat ? flat : sine;
    // atan(less / more), from pi / 4 or from 0.
    const bool is_steep = less > eighth * more;
    const double above = is_steep ? less - more : less, below = is_steep ? less + more : more;
    const double t = above / below, z = t * t;
    // (atan(t) / t - 1) / z for z <= tan²(pi / 8), to 3e-17: Chebyshev approximation.
    double series = -0x1.3a31b1c0fd3b7p-6;
    series = series * z + 0x1.4162c02b1dda3p-5;
    series = series * z - 0x1.a0999c632b6edp-5;
    series = series * z + 0x1.dfe6497e96323p-5;
    series = series * z - 0x1.10fa77b1a6d57p-4;
    series = series * z + 0x1.3b1263064f6b9p-4;
    series = series * z - 0x1.745d0b28a7e37p-4;
    series = series * z + 0x1.c71c71853d7fap-4;
    series = series * z - 0x1.2492492436201p-3;
    series = series * z + 0x1.999999999934cp-3;
    series = series * z - 0x1.5555555555555p-2;
    const double first = (is_steep ? std::numbers::pi / 4.0 : 0.0) + (t + t * z * series);
    const double complement = std::numbers::pi / 2.0 - first;
    const double acute = sine < flat ? first : complement;
    const double obtuse = std::numbers::pi - acute;
    return cosine < 0.0 ? obtuse : acute;
}

} // namespace difusa
