// Faces that lie on others in the same plane, such as a lamp flush with the ceiling or a cabinet that stands on a floor
// without thickness: set apart by a hair, so that it is settled which of them is in front.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/mesh/mesh.h>

#include <vector>

namespace difusa {

/// A face that was moved off another one.
struct MovedFace {
    Index triangle, other;
    Vec3 place; ///< where they overlapped
};

struct SetApart {
    double layer = 0.0;           ///< the distance between faces with the same front, 2^-20 of the diameter
    double gap = 0.0;             ///< that between bodies and sheets, 2^-22 of it; both are larger far from the origin
    bool given_up = false;        ///< nothing was moved though there may be such faces
    std::vector<MovedFace> moved; ///< one of each face of the file, in their order
};

/// Moves triangles that overlap in one plane apart, along their normals:
///
/// - Of two faces with the same front, the smaller is put in front, one layer after the other. Else chance would decide
///   which of them a ray meets, and both would take up the light. What counts is the area of all that continues a face
///   in its plane, and of the faces of its material that lie under the same other face, such as tiles. Of faces that
///   are alike in size, the later one is in front, unless a third is between them. A layer is twice as high as what
///   counts as touching (wall_rounding in discretisation/separators.h): elements do not reach from the open surface
///   below it.
/// - A face of a closed body (its fronts outside) that lies on the front of a single sheet which goes on beyond it is
///   drawn into the body, by a gap that is small enough for its walls to touch the sheet as before. Else it would see
///   what is behind the sheet: locally the two are like the sides of a wall without thickness.
///
/// All others with opposite fronts are the two sides of a sheet, and stay together. Heights that single precision
/// cannot tell count as none, and overlaps of less than a thousandth of the smaller triangle. Points that are shared
/// with faces that stay where they are become two. Triangles keep their numbers and orientation; the mesh, which has
/// been derived, is derived again if anything has moved. Gives up if the boxes of more than a million pairs of
/// triangles and 100 of each triangle touch, or if a face would reach beyond a symmetry plane or a period. Throws
/// Interrupted.
SetApart set_apart(Mesh& mesh, const Execution& execution = {});

} // namespace difusa
