// Gradients of goals as a table.
#pragma once

#include <difusa/bake/result.h>
#include <difusa/radiosity/goal_gradient.h>

#include <span>
#include <string>

namespace difusa {

/// Comma-separated values: goal, kind, name, present value R G B, gradient R G B of the goal's mean irradiance in W/m².
/// Kinds:
///   mean         the goal: its mean irradiance is the value; no gradient
///   group        a light group; the value is 1, a factor on its light
///   emission     of a material, W/m²
///   reflectance  of a material; of one with colours at its vertices a factor on them, 1
///   face         the emission of a face of the mesh file, W/m², its name being its number; with `faces` only
std::string gradient_table(const BakeResult& result, std::span<const GoalGradient> gradients, bool faces);

} // namespace difusa
