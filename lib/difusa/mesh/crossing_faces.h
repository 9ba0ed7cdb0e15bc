// Detection of triangles that pass through each other, by exact predicates.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/core/types.h>
#include <difusa/mesh/mesh.h>

#include <array>
#include <optional>
#include <vector>

namespace difusa {

/// True if two triangles cross: their interiors intersect, and they are not coplanar. Triangles that merely touch do
/// not cross: a wall standing on a floor, neighbours at an edge or a vertex (which cross if they also intersect
/// elsewhere), and a wall that passes through a floor exactly along an edge between two of its triangles, either of
/// which ends there. Coplanar overlaps are not crossings: neither triangle reaches the other side of the other.
bool triangles_cross(const std::array<Vec3, 3>& p, const std::array<Vec3, 3>& q);

/// All pairs of triangles that cross, the lower number first, in order. Nothing if the bounding boxes of more than a
/// million pairs plus 100 per triangle overlap, as in a fan of very many triangles around one vertex: testing each pair
/// could take hours. Throws Interrupted.
std::optional<std::vector<std::array<Index, 2>>> find_crossing_triangles(const Mesh& mesh,
                                                                         const Execution& execution = {});

/// The midpoint of the segment in which two crossing triangles intersect, to within rounding.
Vec3 middle_of_crossing(const std::array<Vec3, 3>& p, const std::array<Vec3, 3>& q);

} // namespace difusa
