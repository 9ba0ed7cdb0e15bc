// A field on a triangle mesh with everything to be stored about it in a file, and its writers.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/core/types.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace difusa {

/// Values owned by someone else, who keeps them as long as the field is in use.
using ValuesView = std::reference_wrapper<const Values>;

/// One array over points or cells.
struct FieldArray {
    std::string name;
    std::string unit;                    ///< "W/m^2", or "" for none
    std::vector<std::string> components; ///< names, {"R","G","B"}; empty for a scalar
    std::variant<Values, ValuesView, std::vector<std::uint8_t>, std::vector<std::int32_t>> data; ///< row by row
};

/// The array's real numbers; null if it is one of integers.
inline const Values* values_of(const FieldArray& array) {
    const auto* view = std::get_if<ValuesView>(&array.data);
    return view != nullptr ? &view->get() : std::get_if<Values>(&array.data);
}

/// One entry of the file's field data: text, or numbers.
struct FieldNote {
    std::string name;
    std::variant<std::string, std::vector<double>> value;
};

/// A triangle mesh, or (no triangles) a point cloud.
struct FieldFile {
    std::vector<Vec3> points;
    std::vector<Vec3> normals; ///< empty, or one per point
    std::vector<std::array<Index, 3>> triangles;
    std::vector<FieldArray> point_arrays;
    std::vector<FieldArray> cell_arrays;
    std::vector<FieldNote> notes;
    std::string active_colours; ///< name of the 3-component uint8 point array that viewers should show (PLY: red green
                                ///< blue; glTF: COLOR_0)
    std::string quality;        ///< name of the scalar point array that PLY stores as `quality`
    Vec3 up = Vec3::UnitZ();    ///< unit: glTF has its own
};

/// Writes VTK XML PolyData (`.vtp`: everything; a point cloud gets one vertex cell per point), PLY (`.ply`, binary
/// little-endian: geometry, normals, colours, quality, and the notes as comments) or glTF (`.glb`: geometry, normals,
/// colours, real numbers at the points, and the notes as extras), chosen by the file name.
///
/// The file appears under its name only once it is complete: it is written next to it under a temporary name, and
/// renamed. Throws UsageError for another extension or a name that is not a file's ("-", a directory, a device),
/// ResourceError if it cannot be written (directory missing, no permission, disk full), naming the file; no temporary
/// file is left behind, and an older file under this name stays as it was.
void write_field(const FieldFile& field, const std::filesystem::path& file, const Execution& execution = {});

/// For fields that have a value everywhere: throws InternalError, naming array and vertex (or cell), if a position, a
/// normal or a number in an array is NaN or infinite.
void require_finite(const FieldFile& field);

/// Throws what `write_field` or `write_whole_file` would throw for this name, before any work is done: unknown
/// extension (if `field`), not a file, directory missing or not writable.
void check_output_path(const std::filesystem::path& file, bool field);

/// Writes `content` as `write_field` does: completely or not at all.
void write_whole_file(const std::filesystem::path& file, const std::string& content);

} // namespace difusa
