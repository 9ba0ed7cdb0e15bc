// The mesh a baked field is written on: the refined input mesh, with vertices split where the field may jump.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/mesh/mesh.h>

#include <array>
#include <vector>

namespace difusa {

/// Triangles over vertices where fields are evaluated.
struct OutputMesh {
    /// #V. `normal` is the shading normal: the angle-weighted mean over the smooth surface around the vertex; `face` is
    /// one of the input triangles around it, of the same material and region as the vertex.
    std::vector<SurfacePoint> vertices;
    std::vector<std::array<Index, 3>> triangles; ///< #F, counterclockwise from the front
    std::vector<Index> face;                     ///< #F, the triangle of the input mesh it is part of
};

/// Refines until no edge is longer than `max_edge` (longest edges first, each split at its midpoint, identically on
/// both sides of an edge: no cracks), keeping input vertices and the number of the input triangle. Edges along the
/// inside of needles are flipped across them instead.
///
/// Neighbouring triangles share vertices exactly where the surface is smooth (the input triangles turn by at most
/// Mesh::crease_angle across a manifold edge), of one material and without a seam; elsewhere each side has its own.
/// `seams`: empty, or of side 3t + k, from corner k of triangle t to the next, whether colours jump across it
/// (Scene::texture_seams). Vertices have shading normals. Throws ResourceError if more than `triangle_limit` triangles
/// would result.
OutputMesh refine(const Mesh& mesh, double max_edge, std::size_t triangle_limit, const Execution& execution,
                  const std::vector<char>& seams = {});

/// About the number of triangles of the refined mesh; an upper estimate.
double expected_output_triangles(const Mesh& mesh, double max_edge);

/// Throws what `refine` would where a lower bound of the number of triangles exceeds the limit.
void check_refinement(const Mesh& mesh, double max_edge, std::size_t triangle_limit);

} // namespace difusa
