// The viewpoint of a picture.
#pragma once

#include <difusa/core/types.h>

namespace difusa {

/// A pinhole camera.
struct Camera {
    Vec3 eye = Vec3::Zero();
    Vec3 towards = -Vec3::UnitZ(); ///< unit, the middle of the picture
    Vec3 up = Vec3::UnitY(); ///< unit, upwards in the picture; not parallel to `towards`, but need not be normal to it
    double view_angle = 0.7; ///< from the lower to the upper edge of the picture, in radians, in (0, pi)
};

} // namespace difusa
