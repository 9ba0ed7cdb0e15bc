// Places of the sensors of a grid.
#pragma once

#include <difusa/bake/options.h>
#include <difusa/bake/result.h>

#include <string>
#include <vector>

namespace difusa {

/// A grid's points and the normal of its face.
struct GridPlaces {
    std::vector<Vec3> positions; ///< row by row
    Vec3 normal = Vec3::UnitZ();
};

/// The smallest rectangle around the face with a side along one of its sides (that along a coordinate axis projected
/// onto its plane, if it is hardly larger), less the margin on each side, is divided into equal cells no longer than
/// the spacing; the sensors are at the height above the centres of those cells that lie on the face and no nearer to
/// its outline than the margin. Throws UsageError: nothing has that name or number; the face is not flat; no or too
/// many sensors.
GridPlaces places_of_grid(const SensorGrid& grid, const Scene& scene);

} // namespace difusa
