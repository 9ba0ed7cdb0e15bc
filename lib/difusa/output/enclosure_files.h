// The exchange of heat in an enclosure as a table.
#pragma once

#include <difusa/form_factors/enclosure.h>

#include <filesystem>
#include <string>
#include <vector>

namespace difusa {

/// Throws UsageError unless the name ends in .csv.
void check_enclosure_file(const std::filesystem::path& file);

/// surface,material,given,area,emissivity,temperature,net_flux,heat,radiosity,irradiance,net_flux_error,
/// temperature_error, and a last line of the surroundings, whose heat is what the surfaces lose, negative. Numbers have
/// as many digits as it takes to read the same ones back.
std::string enclosure_table(const Scene& scene, const Enclosure& enclosure, const std::vector<std::string>& name);

/// For people: a line for each of at most `most` surfaces, and the balance of heat.
std::string enclosure_summary(const Scene& scene, const Enclosure& enclosure, const std::vector<std::string>& name,
                              std::size_t most = 40);

} // namespace difusa
