// Symmetry planes and periods of scene files.
#pragma once

#include <difusa/import/scene_checks.h>
#include <difusa/mesh/repetition.h>

namespace difusa {

/// "symmetry": a list of planes. Throws InputError.
std::vector<Repetition::Plane> scene_symmetry(const SceneChecks& checks, const JsonValue& from);

/// "periodic": a list of translations, in metres. Throws InputError.
std::vector<Vec3> scene_periods(const SceneChecks& checks, const JsonValue& from);

} // namespace difusa
