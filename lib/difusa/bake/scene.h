// The scene of a bake: read, repaired, with the lights of the options added.
#pragma once

#include <difusa/bake/result.h>
#include <difusa/plugin/registry.h>

#include <filesystem>
#include <string>

namespace difusa {

/// Reads and repairs a mesh or scene file into `result`: file, diagnosis, scene, camera, channels, and the options
/// determined by the file. Throws UsageError if the outputs would overwrite a file that is read or a plugin. Phases:
/// "read", "diagnose".
void read_into(BakeResult& result, const Registry& registry, const std::filesystem::path& file,
               const Execution& execution);

/// The same for a scene built by a program, checked as if it were read from a file.
void adopt_into(BakeResult& result, Scene scene, const std::string& name, const Execution& execution);

} // namespace difusa
