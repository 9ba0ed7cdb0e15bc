// Places a user wants to know the light at, and the table of what was found there.
#pragma once

#include <difusa/bake.h>

#include <filesystem>
#include <string>
#include <vector>

namespace difusa {

/// Reads a table of places: on each line x y z, or x y z nx ny nz with a normal of any length but 0, separated by
/// commas, semicolons (not both) or blanks. `#` begins a comment. Numbers may stand in quotation marks. The first line
/// may be a heading, which has to be one of those two, in either case of letters.
/// Throws InputError, naming the line, for anything else, and for a table without places.
std::vector<ListedPoint> read_point_list(const std::filesystem::path& file);

/// BakeResult::listed as a table of comma-separated values with a heading: place asked for, place and normal found,
/// distance between, number of the face in the mesh file, then radiosity, irradiance, direct and indirect irradiance
/// (W/m²), reflectance and emission, each in R G B, and radiosity_of_NAME and irradiance_of_NAME of each light group.
/// Numbers are written so that they read back to the same bits.
std::string point_table(const BakeResult& result);

} // namespace difusa
