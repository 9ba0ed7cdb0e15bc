// The formats a field can be read from, and their common handling of polygons.
#pragma once

#include <difusa/io/field_file.h>

#include <filesystem>
#include <span>
#include <string>

namespace difusa {

/// See `read_field`.
FieldFile read_vtp(const std::filesystem::path& file);
FieldFile read_ply(const std::filesystem::path& file);

/// Collects polygons to be triangulated. The corners are checked against `points`.
class Triangles {
  public:
    /// `file`: for messages. The field's points are set and not changed.
    Triangles(FieldFile& field, std::string file) : field_(field), file_(std::move(file)) {}

    /// A polygon, number `cell` of the file's cells. Throws InputError for a corner that is not a point, or a polygon
    /// of more than three corners that crosses itself.
    void add_polygon(std::span<const std::int64_t> corners, std::size_t cell);

    /// A strip of triangles; every second one runs clockwise.
    void add_strip(std::span<const std::int64_t> corners, std::size_t cell);

    /// #T: the cell each triangle comes from.
    const std::vector<std::size_t>& cells() const { return cells_; }

  private:
    Index point(std::int64_t corner, std::size_t cell) const;
    void add(const std::array<Index, 3>& triangle, std::size_t cell);

    FieldFile& field_;
    std::string file_;
    std::vector<std::size_t> cells_;
};

/// Throws InputError if a coordinate is not finite.
void check_coordinates(const FieldFile& field, const std::string& file);

} // namespace difusa
