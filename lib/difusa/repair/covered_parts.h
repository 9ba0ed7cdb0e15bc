// Leaves out what nothing can be seen of: parts of faces under others in the same plane, and where bodies touch. What
// is there exchanges no radiation with anything, but would count for the area of its surface, and radiate.
#pragma once

#include <difusa/repair/coplanar_layers.h>

namespace difusa {

struct CoveredParts {
    bool given_up = false;         ///< nothing was left out though there may be such parts
    std::vector<CoplanarFace> cut; ///< one of each face of the file that has such a part, in their order
    double area = 0.0;             ///< of all of them
};

/// Cuts off the part of each face that another one with the same front covers, and of both faces where a closed body
/// stands on another one, or on a sheet that goes on beyond it (`CoplanarLayers` tells which). The faces are cut along
/// the edges of what covers them, with the corners of these, so that the floor around a box goes on in its walls. What
/// remains of a triangle has its face, material, and colours and texture coordinates as they were there. Slivers lower
/// than `CoplanarDistances::rounding` are left out. The mesh, which has been derived, is derived again if anything has
/// changed. Gives up if too many faces are close together (`find_overlaps`), or if more would be lost than overlaps.
/// Throws Interrupted, and InputError if nothing remains.
CoveredParts leave_out_covered(Mesh& mesh, const Execution& execution = {});

} // namespace difusa
