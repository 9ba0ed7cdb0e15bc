// Triangles that pass through each other, decided by exact predicates.
#pragma once

#include <difusa/core/types.h>
#include <difusa/mesh/mesh.h>

#include <array>
#include <optional>
#include <vector>

namespace difusa {

/// True if two triangles cross: their interiors meet, and they do not lie in one plane. Triangles that only touch do
/// not cross: a wall that stands on a floor, neighbours at an edge or a vertex (which cross if they also meet
/// elsewhere), and a wall that passes through a floor exactly along an edge between two of its triangles, either of
/// which ends there. Overlaps in one plane are no crossings: neither triangle leads to the other side of the other.
bool triangles_cross(const std::array<Vec3, 3>& p, const std::array<Vec3, 3>& q);

/// All pairs of triangles that cross, the lesser number first, in order. Nothing if the bounding boxes of more than
/// a million pairs and 100 for each triangle overlap, as those of a fan of very many triangles around one vertex do:
/// looking at each pair could take hours.
std::optional<std::vector<std::array<Index, 2>>> find_crossing_triangles(const Mesh& mesh);

/// The middle of the segment in which two triangles that cross meet, as far as rounding tells.
Vec3 middle_of_crossing(const std::array<Vec3, 3>& p, const std::array<Vec3, 3>& q);

} // namespace difusa
