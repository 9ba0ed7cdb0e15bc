// The user's list of points at which to report the light, and the table of results.
#pragma once

#include <difusa/bake.h>

#include <filesystem>
#include <string>
#include <vector>

namespace difusa {

/// Reads a table of points: on each line x y z, or x y z nx ny nz with a normal of any nonzero length, separated by
/// commas, semicolons (not both) or blanks. `#` starts a comment. Numbers may be quoted. The first line may be a
/// heading, which must be one of those two, in upper or lower case.
/// Throws InputError, naming the line, for anything else, and for a table without points.
std::vector<ListedPoint> read_point_list(const std::filesystem::path& file);

/// BakeResult::listed and BakeResult::sensors as comma-separated values with a heading: requested point, surface point
/// found, its normal or the sensor's, distance between the points, number of the face in the mesh file, then radiosity,
/// irradiance, direct and indirect irradiance (W/m²), reflectance and emission, each in R G B, radiosity_of_NAME and
/// irradiance_of_NAME of each light group, of a photometric bake luminance (cd/m²) and illuminances (lux), and with an
/// error estimate that of the radiosity, or of a sensor's irradiance. Of sensors in mid-air, what only a surface has is
/// left empty. With grids, the first column names the grid's face. Numbers are written so that they read back to the
/// same bits.
std::string point_table(const BakeResult& result);

} // namespace difusa
