// Detection of triangles that pass through each other, by exact predicates.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/core/types.h>
#include <difusa/mesh/mesh.h>

#include <array>
#include <functional>
#include <optional>
#include <vector>

namespace difusa {

/// True if two triangles cross: their interiors intersect, and they are not coplanar. Triangles that merely touch do
/// not cross: a wall standing on a floor, neighbours at an edge or a vertex (which cross if they also intersect
/// elsewhere), and a wall that passes through a floor exactly along an edge between two of its triangles, either of
/// which ends there. Coplanar overlaps are not crossings: neither triangle reaches the other side of the other.
bool triangles_cross(const std::array<Vec3, 3>& p, const std::array<Vec3, 3>& q);

/// Calls `act(s, t)` for each pair of triangles whose bounding boxes, wider by `margin` on all sides, touch. False if
/// it gave up because there are more than a million such pairs plus 100 per triangle, as in a fan of very many
/// triangles around one vertex: then only some of them have been visited. Throws Interrupted.
bool for_each_touching_pair(const Mesh& mesh, double margin, const Execution& execution,
                            const std::function<void(Index, Index)>& act);

/// All pairs of triangles that cross, the lower number first, in order. Nothing if there are more pairs than
/// `for_each_touching_pair` visits: testing each could take hours. Throws Interrupted.
std::optional<std::vector<std::array<Index, 2>>> find_crossing_triangles(const Mesh& mesh,
                                                                         const Execution& execution = {});

/// The midpoint of the segment in which two crossing triangles intersect, to within rounding.
Vec3 middle_of_crossing(const std::array<Vec3, 3>& p, const std::array<Vec3, 3>& q);

} // namespace difusa
