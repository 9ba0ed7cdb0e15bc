// Faces that lie on others in the same plane, such as a lamp flush with the ceiling or a cabinet that stands on a floor
// without thickness: set apart by a hair, so that it is settled which of them is in front.
#pragma once

#include <difusa/repair/coplanar_layers.h>

namespace difusa {

struct SetApart {
    double layer = 0.0, gap = 0.0;   ///< CoplanarDistances
    bool given_up = false;           ///< nothing was moved though there may be such faces
    std::vector<CoplanarFace> moved; ///< one of each face of the file, in their order
};

/// Moves triangles that overlap in one plane apart, along their normals, by layers and gaps (`CoplanarLayers`). A layer
/// is twice as high as what counts as touching (wall_rounding in discretisation/separators.h): elements do not reach
/// from the open surface below it. A gap is small enough for the walls of a body to touch what it stands on as before.
///
/// Points that are shared with faces that stay where they are become two. Triangles keep their numbers and orientation;
/// the mesh, which has been derived, is derived again if anything has moved. Gives up if too many faces are close
/// together (`find_overlaps`), or if a face would reach beyond a symmetry plane or a period. Throws Interrupted.
SetApart set_apart(Mesh& mesh, const Execution& execution = {});

} // namespace difusa
