// What the files of a bake say of a thermal scene.
#pragma once

#include <difusa/bake/result.h>
#include <difusa/io/field_file.h>

#include <string>
#include <vector>

namespace difusa {

/// temperature (K), net_flux (positive if heat leaves the surface), radiosity, irradiance (W/m^2), emissivity: scalars
/// that refer to the values.
std::vector<FieldArray> thermal_arrays(const ThermalValues& values);

/// The reference temperature and, if there are some, that of the surroundings.
std::vector<FieldNote> thermal_notes(const BakeResult& result);

/// "given: temperature", "net_flux", "heat", or "mirror" for what has no thermal properties.
std::string given_word(const Material& material);

/// A line for each material, and the balance of heat.
std::string thermal_summary(const BakeResult& result);

} // namespace difusa
