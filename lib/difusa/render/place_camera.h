// Where to look at a scene from, as far as nobody says it.
#pragma once

#include <difusa/mesh/mesh.h>
#include <difusa/rays/visibility.h>
#include <difusa/scene/camera.h>

#include <optional>

namespace difusa {

/// What is known about a camera; each that is there goes before that of the scene.
struct CameraWishes {
    std::optional<Vec3> eye, look_at, towards, up;
    std::optional<double> view_angle; ///< radians
    bool cull_backs = false;          ///< the backs of faces will not be seen
};

/// The camera of the scene's file with what is wished changed. Without one and without an eye, one that shows all of
/// the mesh from outside, from where nearly as many fronts and as few backs are seen as from anywhere; if from
/// everywhere outside mostly backs are seen, as of a closed room, one in a corner of it that looks along the room's
/// diagonal. `up` is +z then. `aspect` is width over height of the picture. Throws UsageError for wishes that
/// contradict each other, or that leave no way to look upright.
Camera place_camera(const CameraWishes& wishes, const std::optional<Camera>& of_scene, const Mesh& mesh,
                    const Visibility& visibility, double aspect);

} // namespace difusa
