// The placement of a mesh in a scene.
#pragma once

#include <difusa/repair/polygon_soup.h>

namespace difusa {

/// x -> linear x + offset.
struct Placement {
    Eigen::Matrix3d linear = Eigen::Matrix3d::Identity();
    Vec3 offset = Vec3::Zero();

    bool moves() const { return linear != Eigen::Matrix3d::Identity() || offset != Vec3::Zero(); }
    bool mirrors() const { return linear.determinant() < 0.0; }
    Vec3 operator()(const Vec3& x) const { return linear * x + offset; }

    /// The composition: the other one first, then this one.
    Placement operator*(const Placement& other) const { return {linear * other.linear, (*this)(other.offset)}; }
};

/// The rotation by an angle about an axis (nonzero), counterclockwise when it points to the viewer. Exact for multiples
/// of 90 degrees about a coordinate axis.
Eigen::Matrix3d rotation(const Vec3& axis, double degrees);

/// Transforms points, lights and camera; mirrored faces are reversed, so that their fronts stay in front. The identity
/// changes no bit.
void place(PolygonSoup& soup, const Placement& placement);

/// Turns every face over.
void turn_over(PolygonSoup& soup);

/// Appends a soup read from another file as a part, or as its own parts. Its corners must be in range (check_indices).
/// The first camera, and the first reflectance of faces without a material, takes precedence.
void append(PolygonSoup& soup, PolygonSoup part);

} // namespace difusa
