// Whether anything can occlude a triangle seen from a point.
#pragma once

#include <difusa/core/box_tree.h>
#include <difusa/mesh/mesh.h>

namespace difusa {

/// The faces of a mesh, found by the tetrahedra they may reach into.
class Shafts {
  public:
    /// Keeps a reference.
    explicit Shafts(const Mesh& mesh);

    /// False only if no face hides any part of triangle t from x, for rays that start at x and end on t and are exempt
    /// from the planes of these two faces (rays/own_plane.h). True if a face may reach into the tetrahedron between
    /// them.
    bool may_be_blocked(const SurfacePoint& x, Index t) const;

  private:
    const Mesh& mesh_;
    BoxTree faces_;
    double rounding_; ///< of heights above planes
};

} // namespace difusa
