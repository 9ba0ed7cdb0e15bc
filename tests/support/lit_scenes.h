// For tests of lights: scenes of one reflectance and their bakes.
#pragma once

#include <difusa/bake.h>
#include <difusa/import/shapes.h>

#include <support/rooms.h>
#include <support/sited.h>

#include <numbers>
#include <utility>
#include <vector>

namespace difusa::lit {

inline constexpr double pi = std::numbers::pi;

inline Scene scene_of(Mesh mesh, double rho) {
    return test::uniform_scene(std::move(mesh), rho, 0.0);
}

/// The box of lib/import/shapes.h, all of one material.
inline Mesh plain_box(const Vec3& low, const Vec3& high, int n, Front front) {
    Mesh mesh = box(low, high, n, front);
    mesh.material.assign(mesh.triangles.size(), 0);
    return mesh;
}

inline BakeOptions quick(double spacing, std::size_t rays = 64) {
    BakeOptions options;
    options.spacing = spacing;
    options.rays = rays;
    options.error_points = 0;
    return options;
}

inline BakeResult baked(const Scene& scene, const BakeOptions& options) {
    return bake(test::registry(), scene, "scene", options, Execution{});
}

/// The light at points of a surface, as a bake evaluates it.
inline PointValues at(const Scene& scene, const BakeOptions& options, const std::vector<SurfacePoint>& x) {
    const BakeResult result = baked(scene, options);
    return result.field().at(x, options.final_gather, 1, "test", Execution{});
}

} // namespace difusa::lit
