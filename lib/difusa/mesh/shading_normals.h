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

    /// Those of a mesh of which points, triangles, normals and regions are known. Triangles in one plane that are
    /// joined are a **facet**. One that turns on two sides or more, by at most Mesh::crease_angle each, to facets not
    /// much smaller than itself, stands for a piece of a curved surface; all others keep their normals: walls beside a
    /// fillet, and the two sides of a single bend.
    ///
    /// Corners at one point have one normal if they can be reached from each other across joined sides (Mesh::twin)
    /// within one region that turn by no more than that. It is the mean of their triangles' normals, weighted by
    /// angles, which is right to second order where these lie evenly around the point; facets much smaller than the
    /// largest one there do not count. Where the surface ends or has a crease, the mean would be that of one side:
    /// there it is extrapolated from the points around, linearly in the tangent plane. Beyond symmetry planes and
    /// periods the surface goes on (Mesh::repetition, settled).
    explicit ShadingNormals(const Mesh& mesh);

    /// The normal at (u, v) of a triangle, as in SurfacePoint, interpolated between those of its corners: unit. It is
    /// exactly that of the face if this is flat, or if it would leave the face's front.
    Vec3 at(Index triangle, double u, double v, const Vec3& face_normal) const {
        return fan_.empty() || curved_[triangle] == 0 ? face_normal : interpolated(triangle, u, v, face_normal);
    }

    /// The same at a vertex that triangles may share: on the sides of flat faces, too, it is interpolated between those
    /// of the corners, the same from both.
    Vec3 at_vertex(Index triangle, double u, double v, const Vec3& face_normal) const;

    /// `at` is that of the face everywhere.
    bool flat() const;

  private:
    Vec3 interpolated(Index triangle, double u, double v, const Vec3& face_normal) const;

    std::vector<Index> fan_;   ///< #T times 3: of each corner; empty if the surface turns nowhere but at creases
    std::vector<Vec3> normal_; ///< #fans: unit, or zero where the normals cancel
    std::vector<char> curved_; ///< #T, if there are fans: the face is not flat
};

} // namespace difusa
