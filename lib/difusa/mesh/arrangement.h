// Triangulates what segments divide the plane into.
#pragma once

#include <difusa/core/types.h>

#include <Eigen/Core>

#include <array>
#include <span>
#include <utility>
#include <vector>

namespace difusa {

/// Triangles none of whose interiors a segment crosses.
struct Arrangement {
    std::vector<Eigen::Vector2d> points;         ///< those given, then those in which segments cross
    std::vector<std::array<Index, 3>> triangles; ///< counterclockwise, sorted; together the convex hull of the points
};

/// The constrained Delaunay triangulation of points (finite) and of segments between them, which may cross, overlap and
/// repeat each other. Of points closer than `rounding` the first is used, and segments that pass a point as closely go
/// through it. Predicates are exact; crossings are rounded.
Arrangement arrange(std::span<const Eigen::Vector2d> points, std::span<const std::pair<Index, Index>> segments,
                    double rounding);

} // namespace difusa
