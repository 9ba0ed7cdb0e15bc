// Random points, directions and rotations for tests.
#pragma once

#include <difusa/core/random.h>
#include <difusa/mesh/mesh.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace difusa::test {

/// Uniform over the sphere.
inline Vec3 random_direction(RandomStream& random) {
    const double z = 2.0 * random.uniform() - 1.0, angle = 2.0 * std::numbers::pi * random.uniform();
    const double radius = std::sqrt(std::max(0.0, 1.0 - z * z));
    return {radius * std::cos(angle), radius * std::sin(angle), z};
}

inline Eigen::Matrix3d random_rotation(RandomStream& random) {
    const Vec3 axis = random_direction(random);
    return Eigen::AngleAxisd(2.0 * std::numbers::pi * random.uniform(), axis).toRotationMatrix();
}

/// Uniform over a triangle of the mesh.
inline SurfacePoint random_point(const Mesh& mesh, Index face, RandomStream& random) {
    const double root = std::sqrt(random.uniform()), part = random.uniform();
    return mesh.at(face, root * (1.0 - part), root * part);
}

/// `count` points, uniform over the whole surface.
inline std::vector<SurfacePoint> random_points(const Mesh& mesh, std::size_t count, RandomStream random) {
    std::vector<double> below;
    double sum = 0.0;
    for (const double area : mesh.areas) {
        below.push_back(sum += area);
    }
    std::vector<SurfacePoint> points;
    for (std::size_t i = 0; i < count; ++i) {
        const auto place = std::upper_bound(below.begin(), below.end(), random.uniform() * sum);
        const auto face = static_cast<Index>(std::min<std::ptrdiff_t>(place - below.begin(), std::ssize(below) - 1));
        points.push_back(random_point(mesh, face, random));
    }
    return points;
}

/// Corners, middles of edges and centroids of every triangle: where coverage and interpolation go wrong first.
inline std::vector<SurfacePoint> special_points(const Mesh& mesh) {
    std::vector<SurfacePoint> points;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        for (const auto& [u, v] : std::initializer_list<std::pair<double, double>>{
                 {0, 0}, {1, 0}, {0, 1}, {0.5, 0}, {0.5, 0.5}, {0, 0.5}, {1.0 / 3, 1.0 / 3}}) {
            points.push_back(mesh.at(t, u, v));
        }
    }
    return points;
}

} // namespace difusa::test
