// Scene files: meshes in their places, materials, lights, sky and camera, in JSON. The format: data/SCENE_FORMAT.md.
#pragma once

#include <difusa/repair/polygon_soup.h>

#include <filesystem>
#include <functional>
#include <string_view>

namespace difusa {

class Registry;

/// Reads a mesh file for a scene.
using MeshSource = std::function<PolygonSoup(const std::filesystem::path& file)>;

/// Reads `file`: a scene file (.json) with all that it names, or a mesh file with the reader for its extension.
/// Everything is in metres, watts, and linear R, G, B then; faces are numbered through in the order of the meshes,
/// which PolygonSoup::parts tells apart. Throws InputError naming file, line and remedy for what is malformed, unknown
/// or out of range, and what `read_soup` and `read_image` do.
PolygonSoup read_scene(const Registry& registry, const std::filesystem::path& file);

/// A scene file from memory; `name` is for messages and for finding files beside it.
PolygonSoup parse_scene(std::string_view content, const std::filesystem::path& name, const MeshSource& meshes);

} // namespace difusa
