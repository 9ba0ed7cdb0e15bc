// The sphere of directions divided into parts of equal solid angle. Light leaving a scene is recorded by part number,
// so that any sky can be applied afterwards.
#pragma once

#include <difusa/core/types.h>
#include <difusa/scene/scene.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace difusa {

/// `bands` bands of equal height along the z axis, each divided into `2 bands` parts of equal azimuth.
class SkyParts {
  public:
    static constexpr Index bands = 64;
    static constexpr Index count = 2 * bands * bands;

    /// The part containing the unit direction.
    static Index at(const Vec3& towards) {
        const double turn = std::atan2(towards[1], towards[0]) / (2.0 * std::numbers::pi);
        const auto cell = [](double part, Index cells) {
            return static_cast<Index>(std::clamp(part * cells, 0.0, static_cast<double>(cells - 1)));
        };
        return cell(0.5 * (towards[2] + 1.0), bands) * 2 * bands + cell(turn < 0.0 ? turn + 1.0 : turn, 2 * bands);
    }

    /// The direction at (u, v) in [0,1]² of a part, uniform by solid angle.
    static Vec3 direction(Index part, double u, double v) {
        const Index band = part / (2 * bands);
        const double z = 2.0 * (band + u) / bands - 1.0;
        const double azimuth = 2.0 * std::numbers::pi * (part % (2 * bands) + v) / (2 * bands);
        const double radius = std::sqrt(std::max(0.0, 1.0 - z * z));
        return {radius * std::cos(azimuth), radius * std::sin(azimuth), z};
    }
};

/// pi times the mean radiance of each part of the scene's sky, W/m²: the irradiance of a surface that sees only such a
/// sky. #SkyParts::count by `channels`.
Values sky_radiosity(const Scene& scene, int channels);

} // namespace difusa
