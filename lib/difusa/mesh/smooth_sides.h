// Where the surface continues smoothly from one triangle to the next, in terms of sides and corners.
//
// Corner 3t + k is corner k of triangle t; side 3t + k runs from it to the next corner of t.
#pragma once

#include <difusa/mesh/mesh.h>

#include <utility>
#include <vector>

namespace difusa {

inline std::size_t triangle_of(std::size_t side) {
    return side / 3;
}
inline std::size_t after(std::size_t side) {
    return side % 3 == 2 ? side - 2 : side + 1;
}
inline std::size_t before(std::size_t side) {
    return side % 3 == 0 ? side + 2 : side - 1;
}
inline Index point_at(const Mesh& mesh, std::size_t corner) {
    return mesh.triangles[corner / 3][corner % 3];
}

/// Normals at this distance or less are those of one plane: well above the rounding of coordinates.
inline constexpr double same_normal = 1e-6;

/// #sides: the side each is joined to, or none. Joined sides share an edge and run in opposite directions.
using Twins = std::vector<Index>;

/// The joined sides of the mesh (Mesh::twin) within one region, across which it turns by at most `crease_angle`
/// radians.
Twins join_smooth_sides(const Mesh& mesh, double crease_angle);

/// Separates the sides across which the reflectance may jump: different materials or corner colours, and `seams`
/// (empty, or of each side whether it is one).
Twins part_materials(const Mesh& mesh, Twins twin, const std::vector<char>& seams);

/// Appends to `open` the triangles beside one, across joined sides, that continue it in one plane, if `enter(other)`
/// tells that they are new.
template <class Enter>
void continue_plane(const Mesh& mesh, const Twins& twin, Index triangle, std::vector<Index>& open, const Enter& enter) {
    for (std::size_t side = 3 * std::size_t{triangle}; side < 3 * std::size_t{triangle} + 3; ++side) {
        const Index other = twin[side] == none ? none : twin[side] / 3;
        if (other != none && (mesh.normals[triangle] - mesh.normals[other]).norm() <= same_normal && enter(other)) {
            open.push_back(other);
        }
    }
}

/// The **fan** of each corner: all corners at its point that can be reached across joined sides. Returns the number of
/// each corner's fan, in the order of their first corners, and how many there are.
std::pair<std::vector<Index>, Index> number_fans(const Twins& twin);

} // namespace difusa
