// Meshes of simple shapes whose points lie on the ideal surface, for scenes with known solutions. All are derived and
// have material 0; original_face numbers the triangles.
#pragma once

#include <difusa/mesh/mesh.h>

#include <functional>

namespace difusa {

/// The side of a closed or curved shape that is its front.
enum class Front { outside, inside };

/// The rectangle with corner `a` and edges `u`, `v`, divided into nu by nv cells of two triangles; its front is u × v.
Mesh rectangle(const Vec3& a, const Vec3& u, const Vec3& v, int nu = 1, int nv = 1);

/// The box [low, high]; each face of n by n cells, material 0 to 5: x low, x high, y low, y high, z low, z high.
Mesh box(const Vec3& low, const Vec3& high, int n, Front front);

/// A disc in the plane z = 0 around the origin, facing up, in `rings` rings of equal width, ring k of 6 (2k+1)
/// triangles. Its area falls short of pi R² by about (pi / 6 rings)² 2/3 of it.
Mesh disc(double radius, int rings);

/// The part of the sphere around the origin within `half_angle` of its lowest point, in `rings` rings like a disc;
/// half_angle in (0, pi).
Mesh spherical_cap(double radius, double half_angle, int rings, Front front);

/// The sphere around the origin: an icosahedron, subdivided into four and projected onto the sphere `halvings` times.
Mesh sphere(double radius, int halvings, Front front);

/// The wall of a cylinder around the z axis from -length/2 to length/2: n faces around by m along.
Mesh cylinder(double radius, double length, int n, int m, Front front);

/// x -> x + offset.
void move(Mesh& mesh, const Vec3& offset);

/// Adds the surface of `other` to `mesh` as additional materials, starting at `material`; nothing is welded.
void add(Mesh& mesh, const Mesh& other, Index material);

} // namespace difusa
