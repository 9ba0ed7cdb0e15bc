// Where a mesh stands in a scene.
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

    /// The other one first, then this one.
    Placement operator*(const Placement& other) const { return {linear * other.linear, (*this)(other.offset)}; }
};

/// The rotation by an angle about an axis (not zero), counterclockwise when it points to the viewer. Exact for
/// multiples of 90 degrees about a coordinate axis.
Eigen::Matrix3d rotation(const Vec3& axis, double degrees);

/// Moves points, lights and camera; mirrored faces run the other way round, so that their fronts stay in front.
/// A placement that changes nothing changes no bit.
void place(PolygonSoup& soup, const Placement& placement);

/// Appends a soup that was read from another file as a part, or as its own parts. Its corners must be in range
/// (check_indices). Of cameras, and reflectances of faces without a material, the first counts.
void append(PolygonSoup& soup, PolygonSoup part);

} // namespace difusa
