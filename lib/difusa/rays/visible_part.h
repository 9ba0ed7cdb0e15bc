// What of a polygon is not hidden by triangles in front of it.
#pragma once

#include <difusa/core/types.h>

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace difusa {

/// A small convex polygon in space.
struct SpatialPolygon {
    static constexpr std::size_t most = 18;
    std::array<Vec3, most> corner; ///< the first `count`
    std::size_t count = 0;
    bool is_cut_short = false; ///< it had more corners than `most`

    SpatialPolygon() = default;
    explicit SpatialPolygon(std::span<const Vec3> corners);

    std::span<const Vec3> corners() const { return {corner.data(), count}; }

    /// The part with normal·p >= offset; no corners if less than a triangle remains.
    SpatialPolygon cut(const Vec3& normal, double offset) const;
};

/// A half space, normal·p >= offset.
struct ClipPlane {
    Vec3 normal = Vec3::Zero();
    double offset = 0.0;
};

/// Takes away from `parts`, convex polygons as seen from x, what a triangle hides that is in front of them. Of the
/// triangle counts what is on both sides `within`: before the plane of the parts and above the horizon of x. False,
/// with `parts` as they were, if more than `most` would remain, or one of too many corners.
bool subtract_shadow(const Vec3& x, const std::array<Vec3, 3>& triangle, const std::array<ClipPlane, 2>& within,
                     std::size_t most, std::vector<SpatialPolygon>& parts);

} // namespace difusa
