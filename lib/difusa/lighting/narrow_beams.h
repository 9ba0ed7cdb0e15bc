// Beams of spots and luminaires that are narrow where they meet a surface.
#pragma once

#include <difusa/core/types.h>
#include <difusa/scene/lights.h>

#include <optional>
#include <vector>

namespace difusa {

class NarrowBeams {
  public:
    void add(const PointLight& light);

    /// Of beams that the ball meets and that are at most twice as wide there as it is, the narrowest's share of the
    /// ball's cross-section, at most 1: a few points in the ball may all be beside it. None: there is no such beam.
    std::optional<double> narrowest(const Vec3& centre, double radius) const;

  private:
    struct Beam {
        Vec3 from, along;
        double angle, opening; ///< half angle; radius at the light, m
    };
    std::vector<Beam> beams_;
};

} // namespace difusa
