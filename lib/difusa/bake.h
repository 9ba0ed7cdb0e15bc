// The complete pipeline from a mesh file to a radiosity field:
// read, repair, scene, sites, discretisation, transport, system, solution, error estimate, output.
#pragma once

#include <difusa/bake/options.h>
#include <difusa/bake/result.h>
#include <difusa/core/progress.h>
#include <difusa/plugin/registry.h>

#include <filesystem>
#include <string>

namespace difusa {

/// Bakes `file`, a mesh or a scene (import/scene_file.h). Each step reports itself as a phase of `execution`. Throws
/// UsageError (unknown plugin or parameter; an output that would overwrite an input), InputError (file, or a scene that
/// no light reaches), NotConverged, ResourceError, Interrupted.
BakeResult bake(const Registry& registry, const std::filesystem::path& file, const BakeOptions& options,
                const Execution& execution);

/// Bakes a scene built by a program; `name` is used in place of a file name in messages and reports. The mesh must be
/// derived (Mesh::derive).
BakeResult bake(const Registry& registry, Scene scene, const std::string& name, const BakeOptions& options,
                const Execution& execution);

/// Runs the first steps only: up to the sites, plus an estimate of the rest.
BakeResult dry_run(const Registry& registry, const std::filesystem::path& file, const BakeOptions& options,
                   const Execution& execution);

} // namespace difusa
