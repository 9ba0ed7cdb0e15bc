// Polygon soups for tests, and the motions under which no verdict on a shape may change.
#pragma once

#include <difusa/core/random.h>
#include <difusa/repair/polygon_soup.h>

#include <Eigen/Geometry>

#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace difusa::test {

/// A soup of these points and faces, without materials; face f stands in line 100 + f.
inline PolygonSoup make_soup(std::vector<Vec3> points, const std::vector<std::vector<Index>>& faces) {
    PolygonSoup soup;
    soup.file = "scene.obj";
    soup.points = std::move(points);
    for (const auto& face : faces) {
        soup.add_face(face, none, static_cast<std::uint32_t>(100 + soup.face_count()));
    }
    return soup;
}

/// The faces of a soup as lists.
inline std::vector<std::vector<Index>> faces_of(const PolygonSoup& soup) {
    std::vector<std::vector<Index>> faces;
    for (std::size_t f = 0; f < soup.face_count(); ++f) {
        faces.emplace_back(soup.face(f).begin(), soup.face(f).end());
    }
    return faces;
}

/// x -> scale (R x + offset).
struct Motion {
    std::string name;
    double scale = 1.0;
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    Vec3 offset = Vec3::Zero();

    Vec3 operator()(const Vec3& x) const { return scale * (rotation * x + offset); }
    std::vector<Vec3> operator()(std::vector<Vec3> points) const {
        for (Vec3& point : points) {
            point = (*this)(point);
        }
        return points;
    }
};

/// Scales from 1e-6 to 1e6, upright and tilted, at the origin and a million units away from it.
inline std::vector<Motion> motions() {
    const Eigen::Matrix3d tilt = Eigen::AngleAxisd(0.7, Vec3(1, 2, -0.5).normalized()).toRotationMatrix();
    std::vector<Motion> all;
    for (const double scale : {1e-6, 1.0, 1e6 / 3.0}) {
        for (const bool tilted : {false, true}) {
            for (const bool far : {false, true}) {
                all.push_back({"scale " + std::to_string(scale) + (tilted ? " tilted" : "") + (far ? " far" : ""),
                               scale, tilted ? tilt : Eigen::Matrix3d(Eigen::Matrix3d::Identity()),
                               far ? Vec3(1e6, -7e5, 3e5) : Vec3(Vec3::Zero())});
            }
        }
    }
    return all;
}

/// Corners (x, y, 0) of a polygon.
inline std::vector<Vec3> flat(const std::vector<std::pair<double, double>>& corners) {
    std::vector<Vec3> points;
    for (const auto& [x, y] : corners) {
        points.emplace_back(x, y, 0.0);
    }
    return points;
}

/// A star-shaped polygon around the origin with n corners at equal angles and radii drawn from [0.2, 1].
inline std::vector<Vec3> random_star(std::size_t n, RandomStream random) {
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < n; ++i) {
        const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
        const double radius = 0.2 + 0.8 * random.uniform();
        points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0.0);
    }
    return points;
}

} // namespace difusa::test
