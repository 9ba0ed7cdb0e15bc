// Beams of spots and luminaires that are narrow where they meet a surface.
#pragma once

#include <difusa/core/types.h>
#include <difusa/scene/lights.h>

#include <numbers>
#include <optional>
#include <span>
#include <vector>

namespace difusa {

class NarrowBeams {
  public:
    /// Of PointLight::beyond_beam: what is wider is no beam.
    static constexpr double widest = 0.25 * std::numbers::pi;

    void add(const PointLight& light);
    bool any() const { return !beams_.empty(); }

    /// Of beams that may meet the convex hull of the corners, and are there at most twice as wide as a ball around it:
    /// the narrowest's share of the ball's cross-section, at most 1. A few points between the corners may all be beside
    /// it. None: there is no such beam.
    std::optional<double> narrowest(std::span<const Vec3> corners) const;

  private:
    struct Beam {
        Vec3 from, along;
        double angle, opening; ///< half angle; radius at the light, m
        double widening;       ///< of the radius, per length: the tangent of the angle
    };
    std::vector<Beam> beams_;
};

} // namespace difusa
