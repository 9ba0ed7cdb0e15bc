// A surface of which some faces are moved like a rigid body.
#pragma once

#include <difusa/mesh/mesh.h>

#include <Eigen/LU> // determinant

#include <span>
#include <vector>

namespace difusa {

/// x -> rotation x + offset.
struct RigidMotion {
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    Vec3 offset = Vec3::Zero();

    bool is_identity() const { return rotation == Eigen::Matrix3d::Identity() && offset == Vec3::Zero(); }
    Vec3 operator()(const Vec3& x) const { return rotation * x + offset; }
};

/// True if all numbers are finite, and the rotation is one to within 1e-9: it neither scales nor mirrors.
inline bool is_rigid(const RigidMotion& motion) {
    constexpr double rounding = 1e-9;
    const Eigen::Matrix3d& R = motion.rotation;
    return R.allFinite() && motion.offset.allFinite() &&
           (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() <= rounding && R.determinant() > 0.0;
}

/// The mesh with the triangles moved that are marked (#T). Triangles keep their numbers, materials and regions; points
/// that others need where they are get a moved twin, after all others. Points that come to lie where others are remain
/// apart: what is moved up against something touches it, and is not joined to it. The identity changes no bit.
///
/// Throws InputError if part of a region would be moved and part would stay, which would tear the surface, or if what
/// is moved would leave the range of coordinates, or the cell of symmetry planes and periods.
Mesh moved_mesh(const Mesh& mesh, std::span<const char> marked, const RigidMotion& motion);

/// Points of the surface in their places on a mesh with the same triangles: those on marked triangles have gone with
/// them, with shading normals. The others are kept as they are.
std::vector<SurfacePoint> moved_points(std::vector<SurfacePoint> points, const Mesh& mesh,
                                       std::span<const char> marked);

} // namespace difusa
