#include <difusa/bake/sensor_lift.h>

#include <difusa/mesh/nearest_surface.h>
#include <difusa/mesh/triangle_tree.h>
#include <difusa/rays/own_plane.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace difusa {

namespace {

constexpr double lifted = 2.0;         ///< distance from the faces, in those of a sensor that lies on them
constexpr int most_projections = 1024; ///< narrow wedges take some

/// A face that the sensor lies on.
struct LyingOn {
    Index face;
    double alignment; ///< of its normal with the sensor's axis
    Vec3 away;        ///< its normal, or the opposite: towards the side that the sensor belongs to
};

double distance_to_face(const Mesh& mesh, Index face, const Vec3& p) {
    const std::array<Vec3, 3> corner = mesh.corners(face);
    const std::array<double, 3> weight = nearest_on_triangle(p, corner[0], corner[1], corner[2]);
    return (weight[0] * corner[0] + weight[1] * corner[1] + weight[2] * corner[2] - p).norm();
}

} // namespace

SensorLift::SensorLift(const Mesh& mesh)
    : mesh_(mesh), faces_(tree_of_triangles(mesh)), near_(touching * mesh.diameter()), rounding_(plane_rounding(mesh)) {
}

Vec3 SensorLift::operator()(const Sensor& sensor) const {
    const Vec3& p = sensor.position;
    const Vec3 margin = Vec3::Constant(near_);
    std::vector<LyingOn> sides;
    faces_.visit(BoxTree::Box(p - margin, p + margin), [&](Index face, const BoxTree::Box&) {
        if (distance_to_face(mesh_, face, p) <= near_) {
            const Vec3& n = mesh_.normals[face];
            const double alignment = sensor.kind == SensorKind::planar ? n.dot(sensor.axis) : 1.0;
            const bool front = alignment >= -touching || n.dot(p - mesh_.corner(face, 0)) > rounding_;
            sides.push_back({face, alignment, front ? n : Vec3(-n)});
        }
        return false;
    });
    std::sort(sides.begin(), sides.end(), [](const LyingOn& a, const LyingOn& b) {
        return a.alignment != b.alignment ? a.alignment > b.alignment : a.face < b.face;
    });
    std::vector<LyingOn> kept;
    for (const LyingOn& side : sides) {
        if (std::none_of(kept.begin(), kept.end(),
                         [&](const LyingOn& other) { return other.away.dot(side.away) < touching - 1.0; })) {
            kept.push_back(side);
        }
    }
    Vec3 q = p;
    for (int round = 0; round < most_projections; ++round) {
        bool moved = false;
        for (const LyingOn& side : kept) { // projections onto half spaces, one after the other
            const double missing = lifted * near_ - side.away.dot(q - mesh_.corner(side.face, 0));
            if (missing > rounding_) {
                q += missing * side.away;
                moved = true;
            }
        }
        if (!moved) {
            break;
        }
    }
    return q;
}

} // namespace difusa
