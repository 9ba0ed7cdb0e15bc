// Small colour utilities used by many steps.
#pragma once

#include <difusa/core/types.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace difusa {

/// Rec. 709 weights for the luminance of linear R, G, B.
inline const Eigen::Vector3d luminance_weights(0.2126, 0.7152, 0.0722);

inline double luminance(const Rgb& c) {
    return luminance_weights.dot(c.matrix());
}

/// True if all channels are equal.
inline bool equal_channels(const Rgb& c) {
    return c[0] == c[1] && c[1] == c[2];
}

/// A pixel of an Image.
inline Rgb rgb_of(const std::array<float, 3>& pixel) {
    return {static_cast<double>(pixel[0]), static_cast<double>(pixel[1]), static_cast<double>(pixel[2])};
}

/// #rows by 1 or 3 to #rows by 3: a grey scene has three equal channels.
inline Values three_channels(const Values& values) {
    return values.cols() == 3 ? values : Values(values.replicate(1, 3));
}

/// sRGB's transfer function, linear [0,1] (clamped) to [0,1] (IEC 61966-2-1).
inline double srgb(double linear) {
    const double c = std::clamp(linear, 0.0, 1.0);
    return c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1.0 / 2.4) - 0.055;
}

/// Its inverse, [0,1] to [0,1].
inline double linear_of_srgb(double v) {
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

} // namespace difusa
