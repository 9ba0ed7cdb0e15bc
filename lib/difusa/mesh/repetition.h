// How a surface goes on beyond its mesh: symmetry planes, behind which its mirror image lies, and periods, at which it
// repeats. The mesh is one cell of the unfolded surface, which may be infinite, and whose light is as symmetric and
// periodic as the surface itself: one cell of it is solved for.
#pragma once

#include <difusa/core/types.h>

#include <functional>
#include <string>
#include <vector>

namespace difusa {

struct Mesh;

/// Symmetry planes and periods as given, and the walls of the cell that follow from them.
struct Repetition {
    /// How far the mesh may reach beyond a wall, over its diameter.
    static constexpr double tolerance = 1e-6;

    struct Plane {
        Vec3 point = Vec3::Zero();
        Vec3 normal = Vec3::UnitZ(); ///< unit, to the side of the surface
    };
    std::vector<Plane> planes;
    std::vector<Vec3> periods; ///< the surface repeats at these displacements and their negatives

    /// A plane that bounds the cell, which is where normal·p >= offset. Beyond it lies an image of the cell.
    struct Wall {
        Vec3 normal = Vec3::UnitZ(); ///< unit
        double offset = 0.0;
        bool reflects = false;     ///< the image is a reflection; else it is displaced
        Vec3 shift = Vec3::Zero(); ///< from the image beyond the wall back to the cell, if it is displaced

        double height(const Vec3& p) const { return normal.dot(p) - offset; }
        /// Where a point beyond the wall has its counterpart.
        Vec3 back(const Vec3& p) const { return reflects ? Vec3(p - 2.0 * height(p) * normal) : Vec3(p + shift); }
        Vec3 turned(const Vec3& direction) const {
            return reflects ? Vec3(direction - 2.0 * normal.dot(direction) * normal) : direction;
        }
    };
    std::vector<Wall> walls; ///< by `settle_repetition`: planes in their order, then two of each period
    /// Orthonormal directions in which the unfolded surface is infinite: of periods, and across parallel planes.
    std::vector<Vec3> endless;

    bool any() const { return !walls.empty(); }

    /// p -> linear p + offset: an image of the cell in the unfolded surface.
    struct Image {
        Eigen::Matrix3d linear = Eigen::Matrix3d::Identity();
        Vec3 offset = Vec3::Zero();
        Vec3 operator()(const Vec3& p) const { return linear * p + offset; }
        bool reflects() const { return linear.determinant() < 0.0; }
    };

    /// The images of the cell, itself first: all that single planes and wedges make, and of infinite series those at
    /// most `depth` periods, or reflections in a row, away.
    std::vector<Image> images(std::size_t depth) const;
};

/// Brings planes and periods that fit each other to within 1e-5 (of an angle, in radians) exactly into place, and finds
/// the walls; `planes` and `periods` of the mesh's repetition are given. A period's cell begins where the mesh does.
/// If there are walls, Mesh::convex becomes false, and Mesh::shading that of the unfolded surface.
///
/// Possible are planes at right angles, two at an angle of 180°/n of at least 5°, two parallel ones that face each
/// other, and periods at right angles to each other and to all planes. Throws InputError, with the remedy, for anything
/// else, and for a face that lies behind a plane or does not fit into a period by more than 1e-6 of the mesh's
/// diameter; `name`: of a face by its number in the file.
void settle_repetition(Mesh& mesh, const std::function<std::string(Index face)>& name);
void settle_repetition(Mesh& mesh);

/// A length that leads out of the unfolded surface from any of its points, in directions in which it ends.
double reach_out_of(const Mesh& mesh);

} // namespace difusa
