// Whether a scene stands on a floor.
#pragma once

#include <difusa/mesh/mesh.h>

namespace difusa {

/// The area of the fronts that face `up`, one of the coordinate axes, to within 25 degrees, in the lowest twentieth of
/// the bounding box, as a share of the box's cross-section: about 1 for a room or a landscape if `up` is right.
double floor_share(const Mesh& mesh, const Vec3& up);

} // namespace difusa
