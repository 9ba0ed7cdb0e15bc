// Normals of the smooth surface that a mesh stands for.
#pragma once

#include <difusa/core/types.h>

#include <utility>
#include <vector>

namespace difusa {

struct Mesh;

/// Where facets stand for a curved surface, irradiance by their normals is off by the order of their size, and by
/// normals that are interpolated between their corners by that of its square.
class ShadingNormals {
  public:
    ShadingNormals() = default;

    /// Those of a mesh of which points, triangles, normals and regions are known. Corners at one point have one normal
    /// if they can be reached from each other across joined sides (Mesh::twin) within one region, across which it turns
    /// by at most Mesh::crease_angle. It is the mean of their triangles' normals, weighted by angles, which is right to
    /// second order where these lie evenly around the point. Where the surface ends or has a crease, the mean would be
    /// that of one side: there it is extrapolated from the points around, linearly in the tangent plane.
    explicit ShadingNormals(const Mesh& mesh);

    /// The normal at (u, v) of a triangle, as in SurfacePoint, interpolated between those of its corners: unit. It is
    /// exactly that of the face if these agree to within rounding, or if it would leave the face's front.
    Vec3 at(Index triangle, double u, double v, const Vec3& face_normal) const;

    /// All are exactly those of the faces.
    bool flat() const { return fan_.empty(); }

  private:
    std::vector<Index> fan_;   ///< #T times 3: of each corner; empty if flat
    std::vector<Vec3> normal_; ///< #fans: unit, or zero where the normals cancel
};

} // namespace difusa
