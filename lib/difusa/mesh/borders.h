// Whether some triangles of a mesh enclose space without a gap.
#pragma once

#include <difusa/mesh/mesh.h>

#include <span>

namespace difusa {

/// Whether somewhere along its sides the surface of these triangles ends: where an odd number of them meet. A side that
/// others continue in pieces (T-junctions), or from points that are off by rounding, up to 1e-6 of the surface's
/// extent, is no border. Without a border the surface divides space, so that no way leads from the one side to the
/// other; with one, light may get in, through however small a hole.
bool has_border(const Mesh& mesh, std::span<const Index> triangles);

} // namespace difusa
