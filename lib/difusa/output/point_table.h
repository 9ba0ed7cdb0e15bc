// The light at the points that a user listed, and at sensors, as a table.
#pragma once

#include <difusa/bake/result.h>

#include <string>

namespace difusa {

/// BakeResult::listed and BakeResult::sensors as comma-separated values with a heading: requested point, surface point
/// found, its normal or the sensor's, distance between the points, number of the face in the mesh file, then radiosity,
/// irradiance, direct and indirect irradiance (W/m²), reflectance and emission, each in R G B, radiosity_of_NAME and
/// irradiance_of_NAME of each light group, of a photometric bake luminance (cd/m²) and illuminances (lux), and with an
/// error estimate that of the radiosity, or of a sensor's irradiance. Of sensors in mid-air, what only a surface has is
/// left empty. With grids, the first column names the grid's face. Numbers are written so that they read back to the
/// same bits.
std::string point_table(const BakeResult& result);

} // namespace difusa
