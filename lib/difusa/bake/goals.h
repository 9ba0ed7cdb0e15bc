// Goals: parts of the surface whose mean irradiance is wanted, as a user names them.
#pragma once

#include <difusa/bake/options.h>
#include <difusa/core/progress.h>
#include <difusa/radiosity/goal_estimate.h>

#include <filesystem>
#include <vector>

namespace difusa {

/// Reads a JSON file {"goals": [...]}. Each goal has a "name" and either "places", a list of [x, y, z] or
/// [x, y, z, nx, ny, nz], or "materials" and "faces": names, and numbers or ranges [first, last] of them as in the
/// mesh file, from 0. Throws InputError "file:line: ..." for anything else, two goals of one name, or none.
std::vector<GoalRequest> read_goals(const std::filesystem::path& file);

/// The triangles and places meant. Places are the nearest points of the surface whose front turns from the normal, if
/// given, by less than 90°. Throws InputError, naming the goal, for a second goal of one name, ranges of faces that end
/// before they begin, for materials and faces that the scene does not have or that have no area, and places without
/// such a surface; notes places farther from it than `spacing`.
std::vector<Goal> find_goals(const std::vector<GoalRequest>& requests, const Scene& scene, double spacing,
                             const Execution& execution);

} // namespace difusa
