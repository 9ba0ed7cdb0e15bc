// How near a point the surface is that it faces: light varies most beside what is near.
#pragma once

#include <difusa/core/box_tree.h>
#include <difusa/mesh/mesh.h>
#include <difusa/rays/flat_polygon.h>

namespace difusa {

/// A tree over the triangles of a mesh. Queries may run in parallel.
class FacingDistance {
  public:
    /// The mesh must outlive this.
    explicit FacingDistance(const Mesh& mesh);

    /// The least of |y - x| / sin²(β/2) over the points y of other triangles above the plane of the face of x, where β
    /// is the angle between the normals of this face and of the triangle, turned so that x is before it: the distance
    /// itself of what is opposite, twice that of a wall at a right angle, and so far that it does not matter of the
    /// next facet of a smooth surface. `reach` if nothing is nearer. What rises above the plane by no more than
    /// wall_rounding does not count.
    double operator()(const SurfacePoint& x, double reach) const;

  private:
    double of_triangle(Index triangle, const SurfacePoint& x, const Plane& tangent, double least) const;

    const Mesh& mesh_;
    double rounding_;
    BoxTree tree_;
};

} // namespace difusa
