#include <difusa/io/field_reader.h>

#include <difusa/core/error.h>
#include <difusa/import/file_content.h>
#include <difusa/import/text_scanner.h>
#include <difusa/io/field_readers.h>
#include <difusa/mesh/triangulate.h>

#include <utility>

namespace difusa {

FieldFile read_field(const std::filesystem::path& file) {
    check_readable(file);
    const std::string extension = lower_case(file.extension().string());
    if (extension == ".vtp") {
        return read_vtp(file);
    }
    if (extension == ".ply") {
        return read_ply(file);
    }
    throw InputError(file.string() +
                     ": fields are read from .vtp or .ply: in ParaView save it as VTK PolyData (.vtp), " +
                     "after the filter Extract Surface if it is not a surface");
}

void Triangles::add_polygon(std::span<const std::int64_t> corners, std::size_t cell) {
    std::vector<Index> outline;
    for (const std::int64_t corner : corners) {
        outline.push_back(point(corner, cell));
    }
    if (outline.size() == 3) {
        add({outline[0], outline[1], outline[2]}, cell);
        return;
    }
    const auto at = [&](std::size_t k) -> const Vec3& { return field_.points[outline[k]]; };
    for (std::size_t k = outline.size(); k-- > 0 && outline.size() > 2;) {
        if (at(k) == at((k + 1) % outline.size())) {
            outline.erase(outline.begin() + static_cast<std::ptrdiff_t>(k));
        }
    }
    if (outline.size() < 3) {
        return;
    }
    std::vector<Vec3> places;
    for (std::size_t k = 0; k < outline.size(); ++k) {
        places.push_back(at(k));
    }
    const Triangulation pieces = triangulate(places);
    if (pieces.outcome == Triangulation::Outcome::crosses_itself) {
        throw InputError(file_ + ": polygon " + std::to_string(cell + 1) +
                         " crosses itself: triangulate the mesh in the program that made it");
    }
    for (const auto& piece : pieces.triangles) {
        add({outline[piece[0]], outline[piece[1]], outline[piece[2]]}, cell);
    }
}

void Triangles::add_strip(std::span<const std::int64_t> corners, std::size_t cell) {
    for (std::size_t k = 2; k < corners.size(); ++k) {
        const std::size_t odd = k % 2;
        add({point(corners[k - 2 + odd], cell), point(corners[k - 1 - odd], cell), point(corners[k], cell)}, cell);
    }
}

Index Triangles::point(std::int64_t corner, std::size_t cell) const {
    if (corner < 0 || static_cast<std::uint64_t>(corner) >= field_.points.size()) {
        throw InputError(file_ + ": cell " + std::to_string(cell + 1) + " has a corner at point " +
                         std::to_string(corner) + ", but the points are 0 to " +
                         std::to_string(static_cast<std::int64_t>(field_.points.size()) - 1) +
                         ": the file is damaged; write it again");
    }
    return static_cast<Index>(corner);
}

void Triangles::add(const std::array<Index, 3>& triangle, std::size_t cell) {
    field_.triangles.push_back(triangle);
    cells_.push_back(cell);
}

void check_coordinates(const FieldFile& field, const std::string& file) {
    for (std::size_t p = 0; p < field.points.size(); ++p) {
        if (!field.points[p].allFinite()) {
            throw InputError(file + ": point " + std::to_string(p + 1) +
                             " has a non-finite coordinate: write the file again");
        }
    }
}

} // namespace difusa
