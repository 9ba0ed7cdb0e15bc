// The camera and the lights of glTF files.
#pragma once

#include <difusa/import/gltf_input.h>
#include <difusa/import/placement.h>

namespace difusa {

/// A node's placement, and its rotation alone, which a scale of 0 does not affect. NaN: undefined.
struct GltfNodePlace {
    Placement place;
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
};

/// Adds the camera `index` at a node to the soup, if it is the first perspective camera.
void read_gltf_camera(GltfInput& input, const JsonValue& index, const GltfNodePlace& place);

/// Adds the light `index` of KHR_lights_punctual at a node to the soup.
void read_gltf_light(GltfInput& input, const JsonValue& index, const GltfNodePlace& place);

} // namespace difusa
