#include <difusa/lighting/narrow_beams.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace difusa {

void NarrowBeams::add(const PointLight& light) {
    if (const double angle = light.beyond_beam(); angle < 0.25 * std::numbers::pi) {
        beams_.push_back({light.position, light.direction, angle, light.radius()});
    }
}

std::optional<double> NarrowBeams::narrowest(const Vec3& centre, double radius) const {
    std::optional<double> least;
    for (const Beam& beam : beams_) {
        const Vec3 way = centre - beam.from;
        const double distance = way.norm(), reach = radius + beam.opening;
        const double relative = (distance * std::tan(beam.angle) + beam.opening) / radius;
        if (!(relative < 2.0) || (least && relative * relative >= *least)) {
            continue;
        }
        const double off_axis = std::atan2(way.cross(beam.along).norm(), way.dot(beam.along));
        if (distance <= reach || off_axis <= beam.angle + std::asin(reach / distance)) {
            least = std::min(1.0, relative * relative);
        }
    }
    return least;
}

} // namespace difusa
