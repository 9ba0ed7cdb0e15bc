// Thermal properties in scene files.
#pragma once

#include <difusa/import/scene_checks.h>
#include <difusa/scene/material.h>

#include <optional>
#include <string>
#include <vector>

namespace difusa {

/// The members of a material that make it a thermal one.
const std::vector<std::string>& thermal_members();

/// What the material says of itself; nothing if it has none of these members. `mirror`: the share that it reflects
/// specularly. Throws InputError "file:line: ..." for values out of range, for none or several of "temperature",
/// "celsius", "net_flux", "heat" and "adiabatic", for a missing emissivity, and for members that say otherwise what the
/// material reflects or emits.
std::optional<Thermal> scene_thermal(const SceneChecks& checks, const JsonValue& material, const Rgb& mirror);

/// The temperature of the surroundings in K: {"temperature": K} or {"celsius": degrees}.
double scene_surroundings(const SceneChecks& checks, const JsonValue& surroundings);

} // namespace difusa
