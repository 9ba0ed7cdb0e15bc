#include <difusa/bake/sensor_grid.h>

#include <difusa/core/error.h>
#include <difusa/core/text.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace difusa {

namespace {

using Vec2 = Eigen::Vector2d;

constexpr double most_sensors = 1e6;
constexpr double flat = 1e-6; ///< relative to the scene's size, and to a unit normal

[[noreturn]] void refuse(const SensorGrid& grid, const std::string& why) {
    throw InputError("--grid " + grid.on + ": " + why);
}

/// Triangles of the face or material that a grid names.
std::vector<Index> triangles_named(const SensorGrid& grid, const Scene& scene) {
    const Mesh& mesh = scene.mesh;
    std::vector<Index> found;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        if (scene.materials[mesh.material[t]].name == grid.on) {
            found.push_back(t);
        }
    }
    Index face = 0;
    const char* const end = grid.on.data() + grid.on.size();
    const auto [rest, error] = std::from_chars(grid.on.data(), end, face);
    if (found.empty() && error == std::errc() && rest == end) {
        for (Index t = 0; t < mesh.triangles.size(); ++t) {
            if (mesh.original_face[t] == face) {
                found.push_back(t);
            }
        }
    }
    if (found.empty()) {
        std::string names;
        for (std::size_t m = 0; m < scene.materials.size() && m < 20; ++m) {
            names += (names.empty() ? "" : ", ") + scene.materials[m].name;
        }
        refuse(grid, "neither a material nor the number of a face has this name; the materials are " + names);
    }
    return found;
}

/// A flat face with coordinates in its plane.
struct GridPlane {
    Vec3 normal, across, along, origin;
    std::vector<std::array<Vec2, 3>> triangles;
    std::vector<std::array<Vec2, 2>> outline;
    Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity()), high = -low;

    Vec2 at(const Vec3& p) const { return {across.dot(p - origin), along.dot(p - origin)}; }
};

GridPlane plane_of(const SensorGrid& grid, const Mesh& mesh, const std::vector<Index>& triangles) {
    GridPlane plane;
    plane.normal = Vec3::Zero();
    for (const Index t : triangles) {
        plane.normal += mesh.areas[t] * mesh.normals[t];
    }
    plane.normal.normalize();
    plane.origin = mesh.corner(triangles.front(), 0);
    std::map<std::pair<Index, Index>, int> sides;
    for (const Index t : triangles) {
        for (int k = 0; k < 3; ++k) {
            const double off = std::abs(plane.normal.dot(mesh.corner(t, k) - plane.origin));
            if (!(mesh.normals[t].dot(plane.normal) > 1.0 - flat) || off > flat * mesh.diameter()) {
                refuse(grid, "not flat: sensors at one height need a flat face; name one by its number in the file");
            }
            const auto i = static_cast<std::size_t>(k);
            ++sides[std::minmax({mesh.triangles[t][i], mesh.triangles[t][(i + 1) % 3]})];
        }
    }
    for (const Vec3& axis : {Vec3(Vec3::UnitX()), Vec3(Vec3::UnitY()), Vec3(Vec3::UnitZ())}) {
        plane.across = axis - axis.dot(plane.normal) * plane.normal;
        if (plane.across.norm() > 0.6) { // one of the three is at least sqrt(2/3)
            break;
        }
    }
    plane.across.normalize();
    plane.along = plane.normal.cross(plane.across);
    for (const Index t : triangles) {
        plane.triangles.push_back(
            {plane.at(mesh.corner(t, 0)), plane.at(mesh.corner(t, 1)), plane.at(mesh.corner(t, 2))});
        for (const Vec2& corner : plane.triangles.back()) {
            plane.low = plane.low.cwiseMin(corner);
            plane.high = plane.high.cwiseMax(corner);
        }
    }
    for (const auto& [side, count] : sides) {
        if (count == 1) {
            plane.outline.push_back({plane.at(mesh.points[side.first]), plane.at(mesh.points[side.second])});
        }
    }
    return plane;
}

double cross(const Vec2& a, const Vec2& b) {
    return a.x() * b.y() - a.y() * b.x();
}

bool covers(const std::array<Vec2, 3>& t, const Vec2& p, double slack) {
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec2 side = t[(k + 1) % 3] - t[k];
        if (cross(side, p - t[k]) < -slack * side.norm()) {
            return false;
        }
    }
    return true;
}

double distance(const std::array<Vec2, 2>& side, const Vec2& p) {
    const Vec2 way = side[1] - side[0];
    const double along = std::clamp((p - side[0]).dot(way) / way.squaredNorm(), 0.0, 1.0);
    return (p - side[0] - along * way).norm();
}

} // namespace

GridPlaces places_of_grid(const SensorGrid& grid, const Scene& scene) {
    const GridPlane plane = plane_of(grid, scene.mesh, triangles_named(grid, scene));
    const double slack = 1e-9 * scene.mesh.diameter();
    const Vec2 size = plane.high - plane.low - Vec2::Constant(2.0 * grid.margin);
    if (!(size.minCoeff() > 0.0)) {
        refuse(grid, "the margin of " + text_of(grid.margin) + " leaves nothing of a face of " +
                         text_of((plane.high - plane.low).x()) + " by " + text_of((plane.high - plane.low).y()));
    }
    const Vec2 cells = (size / grid.spacing - Vec2::Constant(1e-9)).array().ceil().max(1.0);
    if (!(cells.prod() <= most_sensors)) {
        refuse(grid, "more than a million sensors: give it a larger spacing");
    }
    GridPlaces places;
    places.normal = plane.normal;
    for (double row = 0.5; row < cells.y(); ++row) {
        for (double column = 0.5; column < cells.x(); ++column) {
            const Vec2 p = plane.low + Vec2::Constant(grid.margin) +
                           Vec2(column / cells.x() * size.x(), row / cells.y() * size.y());
            const bool on = std::any_of(plane.triangles.begin(), plane.triangles.end(),
                                        [&](const auto& t) { return covers(t, p, slack); });
            const bool free = std::all_of(plane.outline.begin(), plane.outline.end(),
                                          [&](const auto& side) { return distance(side, p) >= grid.margin - slack; });
            if (on && free) {
                places.positions.push_back(plane.origin + p.x() * plane.across + p.y() * plane.along +
                                           grid.height * plane.normal);
            }
        }
    }
    if (places.positions.empty()) {
        refuse(grid, "no sensor falls on the face: give it a smaller spacing or margin");
    }
    return places;
}

} // namespace difusa
