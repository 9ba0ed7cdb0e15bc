// The mesh of the classical method (L 29): the surface refined to triangles of a given size, the patches, and which of
// them a surface point is on.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/mesh/mesh.h>
#include <difusa/mesh/output_mesh.h>

#include <array>
#include <limits>
#include <vector>

namespace difusa {

class PatchMesh {
  public:
    /// Refines like an output (mesh/output_mesh.h) until no edge is longer than `edge`; vertices are split at creases
    /// (Mesh::crease_angle). Depends on mesh and edge alone. Throws ResourceError if there would be more than
    /// `limit` patches.
    PatchMesh(const Mesh& mesh, double edge, std::size_t limit, const Execution& execution);

    /// The longest edge at which there are about as many patches, or vertices, as sites with this spacing.
    static double edge_for_patches(double spacing) { return 2.5 * spacing; }
    static double edge_for_vertices(double spacing) { return 2.0 * spacing; }

    std::size_t size() const { return refined_.triangles.size(); }
    std::size_t vertex_count() const { return refined_.vertices.size(); }

    /// The vertices of a patch, counterclockwise from the front.
    const std::array<Index, 3>& corners(Index patch) const { return refined_.triangles[patch]; }

    /// The triangle of the input mesh that a patch is part of.
    Index parent(Index patch) const { return refined_.face[patch]; }

    /// With its shading normal, which is the face's where the surface is flat.
    const SurfacePoint& vertex(Index v) const { return refined_.vertices[v]; }

    /// The centroid of a patch.
    SurfacePoint centre(Index patch) const;

    /// The point with these barycentric coordinates in a patch.
    SurfacePoint point(Index patch, const std::array<double, 3>& weight) const;

    double area(Index patch) const { return area_[patch]; }

    struct Place {
        Index patch = none;
        std::array<double, 3> weight{}; ///< barycentric coordinates in the patch, not negative, sum 1
    };

    /// Where x is. Of points on an edge between patches the one is found whose centroid is nearer in these coordinates.
    Place at(const SurfacePoint& x) const;

  private:
    using Flat = Eigen::Vector2d; ///< (u, v) in an input triangle
    void sort_into_cells();
    std::array<double, 3> coordinates(Index patch, const Flat& p) const;

    const Mesh* mesh_;
    OutputMesh refined_;
    std::vector<double> area_;
    std::vector<std::array<Flat, 3>> flat_; ///< #patches: the corners in the parent
    /// The patches of an input triangle by the cells of a grid over its (u, v).
    struct Grid {
        std::size_t first = 0; ///< its first cell
        std::size_t across = 1;
    };
    std::vector<Grid> grids_;             ///< #T
    std::vector<std::size_t> cell_first_; ///< #cells + 1
    std::vector<Index> cell_patch_;
};

} // namespace difusa
