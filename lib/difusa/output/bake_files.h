// The files of a bake: the field, the sites, the report.
#pragma once

#include <difusa/bake.h>
#include <difusa/io/field_file.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace difusa {

/// The baked field on the output mesh; it refers to `result`, which must outlive it.
/// Point arrays: radiosity, irradiance, irradiance_direct, irradiance_indirect, emission (R G B, W/m^2), reflectance (R
/// G B), radiosity_weighted and irradiance_weighted (W/m^2: means of the channels, weighted by their luminance, Rec.
/// 709) or, of a photometric bake, luminance (cd/m^2), illuminance, illuminance_direct and illuminance_indirect (lx;
/// core/photometry.h), display_rgb (uint8, sRGB; the exposure that maps
/// radiosity to linear [0,1] is in the notes), Normals. Cell arrays: original_face_id (number in the mesh file),
/// material_id; with BakeOptions::face_centres also radiosity to illuminance at the centres of the triangles. With
/// light groups, radiosity_of_NAME and irradiance_of_NAME of each, at points and centres. With an error estimate, also
/// error_estimate, error_noise and error_discretisation (W/m^2, ErrorsAt). Notes: versions, options,
/// seed, iterations, residual, times, materials.
/// Of a thermal scene: thermal_arrays (output/thermal_files.h) instead of all of these but the errors and Normals.
/// `exposure`: of display_rgb; absent: that of the result.
FieldFile field_of(const BakeResult& result, std::optional<double> exposure = {});
FieldFile field_of(BakeResult&&, std::optional<double> exposure = {}) = delete;

/// The sites as a point cloud: Normals, radius, area, coefficient (of the irradiance excluding suns, point lights and
/// area lights), irradiance, radiosity, reflectance, emission, original_face_id, region, and scalars as above.
FieldFile sites_of(const BakeResult& result);

/// The report as JSON text; its layout is documented by its fields `schema` and `schema_version` (3).
std::string report_of(const BakeResult& result);

/// A few lines for the user: what was found, and how the bake went.
std::string summary_of(const BakeResult& result);

/// "0.03 s", "4.2 s", "75 s", "12 min", "3.1 h".
std::string format_seconds(double seconds);

/// Where to write each file; an empty name: not written.
struct BakeFiles {
    std::filesystem::path field = {}, sites = {}, report = {};
    std::filesystem::path listed = {};      ///< point_table (output/point_table.h)
    std::filesystem::path transport = {};   ///< write_transport (bake/saved_transport.h)
    std::filesystem::path error_chart = {}; ///< error_chart_of (output/error_chart.h), of a bake with a target

    std::vector<std::filesystem::path> beside_field() const; ///< names that are not empty, without the field's
};

/// Writes field_of, sites_of, point_table, report_of, error_chart_of and the transport as the phase "write" of
/// `execution`. All are written before the first appears under its name: on failure none of them appears, and older
/// files stay as they were. Throws what `write_field`, `require_finite` and `saved_transport_of` throw, and
/// Interrupted.
void write_bake(const BakeResult& result, const BakeFiles& files, const Execution& execution);

/// The factor from radiosity to linear display values: 0.9 over the luminance below which 95 % of the area of
/// non-emitting surfaces lies; 1 if they are all dark.
double display_exposure(const BakeResult& result);

} // namespace difusa
