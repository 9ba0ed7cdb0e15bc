// Whether anything can come between a point and a triangle it looks at.
#pragma once

#include <difusa/core/box_tree.h>
#include <difusa/mesh/mesh.h>

namespace difusa {

/// The faces of a mesh, found by the tetrahedra they may reach into.
class Shafts {
  public:
    /// Keeps a reference.
    explicit Shafts(const Mesh& mesh);

    /// False only if no face hides any part of triangle t from x, rays that start at x and end on t being exempt from
    /// the planes of these two faces (rays/own_plane.h). True if a face may reach into the tetrahedron between
    /// them.
    bool may_be_blocked(const SurfacePoint& x, Index t) const;

  private:
    const Mesh& mesh_;
    BoxTree faces_;
    double rounding_; ///< of heights above planes
};

} // namespace difusa
