// Where the surface continues across each side of a triangle, seen from its front.
#pragma once

#include <difusa/core/types.h>

#include <array>
#include <vector>

namespace difusa {

/// Side 3t + k of triangle t runs from its corner k to the next. Returns for each side the side it is joined to, or
/// none. Joined sides lie on one edge and run in opposite directions.
///
/// Two triangles at an edge are joined. If there are more, those whose fronts bound one wedge of free space are joined:
/// rotating around the edge from the front of one, the front of the other comes next. The two sides of a sheet are thus
/// separate, each whole, and a fin on the back of a wall does not cut its front.
std::vector<Index> join_sides(const std::vector<Vec3>& points, const std::vector<std::array<Index, 3>>& triangles);

} // namespace difusa
