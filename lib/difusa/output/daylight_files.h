// Daylight coefficients as files, and what they give under a sky.
#pragma once

#include <difusa/bake/daylight.h>

#include <filesystem>
#include <string>

namespace difusa {

/// Throws UsageError unless the name ends in .mtx (Radiance) or .npz (NumPy).
void check_daylight_file(const std::filesystem::path& file);

/// Writes to `file`, which appears once it is complete; data/TRANSPORT_FORMAT.md describes the formats. `photometric`:
/// the .npz has illuminances, too. Throws what `check_daylight_file` throws, and ResourceError.
void write_daylight(const DaylightMatrix& matrix, bool photometric, const std::filesystem::path& file);

/// Irradiance at points for a radiance of 1 of the parts of a sky, from a file.
struct DaylightTable {
    SkyDivision sky;
    DaylightCoefficients coefficients;
};

/// Reads a matrix in Radiance's text format: of this program, or of any other whose columns are the ground and the
/// parts of a Reinhart sky. Where the file does not say what is up and north, that is +z and +y. Throws InputError.
DaylightTable read_daylight(const std::filesystem::path& file);

/// Comma-separated values with a heading: number of the point, its position and normal if `points` are known (else
/// empty), irradiance R G B in W/m², illuminance in lux.
std::string daylight_table(const Values& irradiance, const std::vector<SurfacePoint>& points);

} // namespace difusa
