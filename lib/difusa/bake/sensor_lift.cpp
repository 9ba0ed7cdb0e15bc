#include <difusa/bake/sensor_lift.h>

#include <difusa/mesh/nearest_surface.h>
#include <difusa/mesh/triangle_tree.h>
#include <difusa/rays/own_plane.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <tuple>
#include <vector>

namespace difusa {

namespace {

constexpr double lifted = 2.0;   ///< distance from the faces, in those of a sensor that lies on them
constexpr int most_lifts = 1024; ///< narrow wedges take some
constexpr double alike = 1e-9;   ///< directions whose cosines differ by less are the same

/// A face that a sensor lies on.
struct LyingOn {
    Index face;
    double alignment, preference; ///< cosines with the axis of a planar sensor, and with the preferred direction
    double distance;

    bool comes_before(const LyingOn& other) const {
        if (std::abs(alignment - other.alignment) > alike) {
            return alignment > other.alignment;
        }
        if (std::abs(preference - other.preference) > alike) {
            return preference > other.preference;
        }
        return std::tie(distance, face) < std::tie(other.distance, other.face);
    }
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

Sensor SensorLift::operator()(Sensor sensor, const Vec3& towards, Back back) const {
    const Vec3 p = sensor.position, margin = Vec3::Constant(near_);
    Vec3& q = sensor.position;
    struct LeftBelow {
        Index face;
        Vec3 away;
    };
    std::vector<LeftBelow> left; // faces that it has been moved off
    const auto height = [&](const LeftBelow& below) { return below.away.dot(q - mesh_.corner(below.face, 0)); };
    const auto leave = [&](const LeftBelow& below) { q += (lifted * near_ - height(below)) * below.away; };
    const auto away_from = [&](const LyingOn& on) {
        const Vec3& n = mesh_.normals[on.face];
        const bool behind =
            back == Back::in_plane && on.alignment < -touching && n.dot(p - mesh_.corner(on.face, 0)) <= rounding_;
        return behind ? Vec3(-n) : n;
    };
    for (int step = 0; step < most_lifts; ++step) {
        const auto again = std::find_if(left.begin(), left.end(),
                                        [&](const LeftBelow& below) { return height(below) < (1.0 - alike) * near_; });
        if (again != left.end()) { // another face has pushed it back
            leave(*again);
            continue;
        }
        std::optional<LyingOn> first;
        const BoxTree::Box around = BoxTree::Box(q - margin, q + margin).extend(p - margin).extend(p + margin);
        faces_.visit(around, [&](Index face, const BoxTree::Box&) {
            const Vec3& n = mesh_.normals[face];
            const LyingOn on{face, sensor.kind == SensorKind::planar ? n.dot(sensor.axis) : 1.0, n.dot(towards),
                             distance_to_face(mesh_, face, q)};
            const Vec3 away = away_from(on);
            const bool is_settled = std::any_of(left.begin(), left.end(), [&](const LeftBelow& below) {
                return below.face == face || below.away.dot(away) < alike - 1.0;
            });
            // Or it has been moved through the face, off another one.
            const bool is_crossed = distance_to_face(mesh_, face, p) <= near_ &&
                                    std::abs(on.distance + height({face, away})) <= 0.001 * near_;
            if ((on.distance <= near_ || is_crossed) && !is_settled && (!first || on.comes_before(*first))) {
                first = on;
            }
            return false;
        });
        if (!first) {
            break;
        }
        left.push_back({first->face, away_from(*first)});
        leave(left.back());
    }
    return sensor;
}

} // namespace difusa
