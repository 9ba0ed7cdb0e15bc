// Scene files: placed meshes, materials, lights, sky and camera, in JSON. The format: data/SCENE_FORMAT.md.
#pragma once

#include <difusa/repair/polygon_soup.h>

#include <filesystem>
#include <functional>
#include <string_view>

namespace difusa {

class Registry;

/// Reads a mesh file for a scene.
using MeshSource = std::function<PolygonSoup(const std::filesystem::path& file)>;

/// Reads `file`: a scene file (.json) and everything it names, or a mesh file with the reader for its extension.
/// Everything is converted to metres, watts, and linear R, G, B; faces are numbered consecutively in the order of the
/// meshes, which PolygonSoup::parts distinguishes. Throws InputError naming file, line and remedy for anything
/// malformed, unknown or out of range, and what `read_soup` and `read_image` throw.
PolygonSoup read_scene(const Registry& registry, const std::filesystem::path& file);

/// A scene file from memory; `name` is for messages and for finding neighbouring files.
PolygonSoup parse_scene(std::string_view content, const std::filesystem::path& name, const MeshSource& meshes);

} // namespace difusa
