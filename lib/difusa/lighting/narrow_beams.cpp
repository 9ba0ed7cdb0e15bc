#include <difusa/lighting/narrow_beams.h>

#include <algorithm>
#include <cmath>

namespace difusa {

void NarrowBeams::add(const PointLight& light) {
    if (const double angle = light.beyond_beam(); angle < widest) {
        beams_.push_back({light.position, light.direction, angle, light.radius(), std::tan(angle)});
    }
}

std::optional<double> NarrowBeams::narrowest(std::span<const Vec3> corners) const {
    std::optional<double> least;
    if (beams_.empty()) {
        return least;
    }
    Eigen::AlignedBox3d box;
    for (const Vec3& p : corners) {
        box.extend(p);
    }
    const Vec3 centre = box.center();
    const double radius = 0.5 * box.diagonal().norm();
    for (const Beam& beam : beams_) {
        const Vec3 way = centre - beam.from;
        const double distance = way.norm(), reach = radius + beam.opening;
        const double relative = (distance * beam.widening + beam.opening) / radius;
        if (!(relative < 2.0) || (least && relative * relative >= *least)) {
            continue;
        }
        if (std::all_of(corners.begin(), corners.end(),
                        [&](const Vec3& p) { return (p - beam.from).dot(beam.along) <= -beam.opening; })) {
            continue; // behind the light
        }
        const double off_axis = std::atan2(way.cross(beam.along).norm(), way.dot(beam.along));
        if (distance <= reach || off_axis <= beam.angle + std::asin(reach / distance)) {
            least = std::min(1.0, relative * relative);
        }
    }
    return least;
}

} // namespace difusa
