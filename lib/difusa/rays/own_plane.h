// The faces that a ray starting on a face cannot hit: that face, and every face in the same plane. Deciding this by
// face and plane instead of by a minimum distance keeps thin walls, tight corners and tiny scenes opaque.
#pragma once

#include <difusa/mesh/mesh.h>

namespace difusa {

/// Heights above planes within this count as 0: a few hundred units in the last place of the largest coordinate.
inline double plane_rounding(const Mesh& mesh) {
    return mesh.magnitude() * 0x1p-44;
}

/// The rule for one mesh. Cheap to make; keeps a reference to the mesh.
class OwnPlane {
  public:
    explicit OwnPlane(const Mesh& mesh) : mesh_(&mesh), rounding_(plane_rounding(mesh)) {}

    /// True if `met` is the face `own`, or lies in its plane to within the rounding of coordinates (a few hundred units
    /// in the last place of the largest coordinate). `height` is how far above the plane of `own` the ray hits it, t
    /// (n_own · direction): if it is above rounding, planes need not be compared.
    bool exempts(Index own, Index met, double height) const {
        return own != none && (met == own || (height <= rounding_ && coplanar(own, met)));
    }

    /// The distance, in t, within which hits of a ray of this direction coincide to within rounding.
    double slack(const Vec3& direction) const { return rounding_ / direction.norm(); }

  private:
    bool coplanar(Index own, Index met) const {
        const Vec3& n = mesh_->normals[own];
        const Vec3 foot = mesh_->corner(own, 0);
        for (int k = 0; k < 3; ++k) {
            const double height = n.dot(mesh_->corner(met, k) - foot);
            if (height > rounding_ || height < -rounding_) {
                return false;
            }
        }
        return true;
    }
    const Mesh* mesh_;
    double rounding_;
};

} // namespace difusa
