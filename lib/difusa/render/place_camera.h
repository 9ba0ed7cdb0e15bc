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

/// What the rays of a picture meet: shares of them.
struct Coverage {
    double fronts = 0.0, backs = 0.0;
};

/// From rays through a grid of 96 rows.
Coverage coverage_of(const Camera& camera, const Visibility& visibility, double aspect);

/// The camera of the scene file, or else the view that shows most of the scene, with the requested changes; `up`,
/// unless it is requested, is the scene's. A scene whose fronts are seen from outside is shown whole, obliquely from
/// above if most of what is seen from there are fronts, or else from a side or from the top; one that shows mostly
/// backs from everywhere outside, as a closed room does, from a corner inside. An eye alone looks at the scene's
/// centre, or as the scene's camera does; a direction alone looks at the whole from outside, or across the room.
/// Looking straight up or down, `up` is a level direction if it is not requested.
///
/// `aspect` is width over height of the picture. Throws UsageError for requests that contradict each other, or that
/// allow no upright view.
Camera place_camera(const CameraWishes& wishes, const std::optional<Camera>& of_scene, const Vec3& up, const Mesh& mesh,
                    const Visibility& visibility, double aspect);

} // namespace difusa
