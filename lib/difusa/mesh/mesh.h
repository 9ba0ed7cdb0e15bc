// The triangle mesh that everything after the diagnosis works on, and points on it.
#pragma once

#include <difusa/core/types.h>
#include <difusa/mesh/gloss.h>
#include <difusa/mesh/mirrors.h>
#include <difusa/mesh/repetition.h>
#include <difusa/mesh/shading_normals.h>

#include <array>
#include <vector>

namespace difusa {

/// Cosines of normals up to this count as a right angle. A box that is turned has walls at 90° only as far as the
/// rounding of its coordinates allows; without this margin chance would decide which of them are one region.
inline constexpr double perpendicular = 0x1p-20;

/// Where texture coordinates point in a picture: (0, 0) is its lower left corner, (1, 1) its upper right one.
using TextureCoordinates = Eigen::Vector2d;

/// A point of the surface. Where irradiance is received the normal is the shading normal (Mesh::shaded); of points that
/// send light, and wherever nothing else is stated, it is that of the face.
struct SurfacePoint {
    Vec3 position = Vec3::Zero();
    Vec3 normal = Vec3::UnitZ(); ///< unit
    Index face = none;           ///< triangle of the mesh; none: a point in mid-air, which only receives light
    double u = 0.0, v = 0.0;     ///< position = (1-u-v) a + u b + v c for the triangle's corners a, b, c
};

/// Triangles without defects: every index in range, every coordinate finite, every area positive, no two points
/// at one place. Edges and vertices need not be manifold. The front of a triangle is the side from which its
/// corners run counterclockwise; light is received and sent by fronts only.
struct Mesh {
    std::vector<Vec3> points;                                      ///< #P
    std::vector<std::array<Index, 3>> triangles;                   ///< #T
    std::vector<Index> original_face;                              ///< #T, number of the face in the file, from 0
    std::vector<Index> material;                                   ///< #T, number in the scene's materials
    std::vector<std::array<Rgb, 3>> corner_reflectance;            ///< empty, or #T (see Material::vertex_colours)
    std::vector<std::array<TextureCoordinates, 3>> corner_texture; ///< empty, or #T: where textures are looked up
    Mirrors mirrors;                          ///< of the scene's materials (scene/scene.h, settle_mirrors)
    GlossySurfaces glossy;                    ///< likewise (settle_gloss)
    Repetition repetition;                    ///< beyond these triangles
    double crease_angle = 0.6981317007977318; ///< 40°, in radians: where the surface turns more sharply it has an edge.
                                              ///< Call `derive` after a change

    // Derived by `derive`:
    std::vector<Vec3> normals; ///< #T, unit
    std::vector<double> areas; ///< #T
    std::vector<Index> region; ///< #T, see below
    std::vector<Index> twin;   ///< #T times 3: side 3t + k goes on at this side, or none (mesh/twins.h)
    ShadingNormals shading;
    Index region_count = 0;
    double area = 0.0;                            ///< of the whole surface
    Vec3 low = Vec3::Zero(), high = Vec3::Zero(); ///< bounding box
    bool convex = false; ///< known: all of the surface is before or in the plane of each triangle, as in an empty room,
                         ///< so that nothing comes between two points of it

    /// Computes everything that follows from points and triangles.
    ///
    /// A **region** is a set of triangles that one can walk between across joined sides (mesh/twins.h) whose triangles
    /// turn by less than 90° (cosine above `perpendicular`). Basis elements never reach from one region to another:
    /// this keeps the light of a shelf off the table below it, where normals cannot tell them apart.
    ///
    /// Throws InputError if there is no triangle, or one without original face, material or area, or with a corner that
    /// is out of range or not finite.
    void derive();

    /// False if points or triangles have changed since then, other than by little.
    bool is_derived() const;

    /// Turns a triangle over, with the colours and texture coordinates of its corners. What is derived is not updated.
    void turn_over(Index triangle);

    const Vec3& corner(Index triangle, int k) const { return points[triangles[triangle][static_cast<std::size_t>(k)]]; }
    std::array<Vec3, 3> corners(Index triangle) const {
        return {corner(triangle, 0), corner(triangle, 1), corner(triangle, 2)};
    }

    /// The point with barycentric coordinates (1-u-v, u, v) and the face's normal.
    SurfacePoint at(Index triangle, double u, double v) const {
        return {(1.0 - u - v) * corner(triangle, 0) + u * corner(triangle, 1) + v * corner(triangle, 2),
                normals[triangle], triangle, u, v};
    }

    /// The normal of the face that x is on; that of x in mid-air.
    const Vec3& face_normal(const SurfacePoint& x) const { return x.face == none ? x.normal : normals[x.face]; }

    /// The same point with its shading normal.
    SurfacePoint shaded(SurfacePoint x) const {
        x.normal = shading.at(x.face, x.u, x.v, normals[x.face]);
        return x;
    }

    /// The smallest axis-parallel box around a triangle.
    Eigen::AlignedBox3d box(Index triangle) const {
        Eigen::AlignedBox3d box(corner(triangle, 0));
        return box.extend(corner(triangle, 1)).extend(corner(triangle, 2));
    }

    /// Length of the bounding box' diagonal.
    double diameter() const { return (high - low).norm(); }

    /// The largest absolute coordinate: what rounding errors of positions are relative to.
    double magnitude() const { return low.cwiseAbs().cwiseMax(high.cwiseAbs()).maxCoeff(); }
};

} // namespace difusa
