// Scenes as files. Numbers in text files are rounded to nine digits and those in binary files to single precision, so
// that the last bit of a sine does not depend on the machine.
#pragma once

#include "scene.h"
#include "surface.h"

#include <filesystem>
#include <string>

namespace scenes {

// Each throws std::runtime_error, naming the file, if it cannot be written.

/// `directory`/`name`.obj with its materials in `name`.mtl.
void write_obj(const Surface& surface, const std::filesystem::path& directory, const std::string& name);

/// `directory`/`name`.off with a colour per face; emitting materials are not supported by this format.
void write_off(const Surface& surface, const std::filesystem::path& directory, const std::string& name);

/// `directory`/`name`.ply, binary, little endian, with a colour per face; likewise.
void write_ply(const Surface& surface, const std::filesystem::path& directory, const std::string& name);

/// The surface as `directory`/`name`.obj and .mtl, and `name`.json, which refers to them and holds lights and camera.
void write_scene(const Scene& scene, const std::filesystem::path& directory, const std::string& name);

void write_text(const std::string& content, const std::filesystem::path& file);

} // namespace scenes
