// Chooses the viewpoint of a scene where it is not given.
#pragma once

#include <difusa/mesh/mesh.h>
#include <difusa/rays/visibility.h>
#include <difusa/scene/camera.h>

#include <optional>

namespace difusa {

/// Requested camera settings; each one given overrides that of the scene.
struct CameraWishes {
    std::optional<Vec3> eye, look_at, towards, up;
    std::optional<double> view_angle; ///< radians
    bool cull_backs = false;          ///< back faces will not be visible
};

/// The camera of the scene file with the requested changes. Without one and without an eye, one that shows the whole
/// mesh from outside, from a direction that sees nearly as many fronts and as few backs as any; if mostly backs are
/// seen from everywhere outside, as for a closed room, one in a corner of it that looks along the room's diagonal. `up`
/// is +z then. `aspect` is width over height of the picture. Throws UsageError for requests that contradict each other,
/// or that allow no upright view.
Camera place_camera(const CameraWishes& wishes, const std::optional<Camera>& of_scene, const Mesh& mesh,
                    const Visibility& visibility, double aspect);

} // namespace difusa
