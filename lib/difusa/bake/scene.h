// The scene of a bake: read, repaired, lit by what the options add.
#pragma once

#include <difusa/bake/result.h>
#include <difusa/plugin/registry.h>

#include <filesystem>
#include <string>

namespace difusa {

/// Reads and repairs a mesh or scene file into `result`: file, diagnosis, scene, camera, channels, and the options that
/// the file answers. Phases: "read", "diagnose".
void read_into(BakeResult& result, const Registry& registry, const std::filesystem::path& file,
               const Execution& execution);

/// The same for a scene made by a program, which is checked as reading a file would have.
void adopt_into(BakeResult& result, Scene scene, const std::string& name, const Execution& execution);

} // namespace difusa
