// Collects the findings of a diagnosis: counts everything, remembers the first few places.
#pragma once

#include <difusa/repair/diagnosis.h>

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace difusa {

/// Kinds of findings, in the order of the report. Their codes and meanings are listed in diagnosis.h.
enum class Defect : std::size_t {
    repeated_corners,
    too_few_corners,
    zero_area_faces,
    zero_area_pieces,
    duplicate_faces,
    duplicate_pieces,
    duplicate_materials,
    duplicate_points,
    unreferenced_points,
    orphaned_points,
    inconsistent_orientation,
    one_sided_pieces,
    non_planar_polygons,
    concave_polygons,
    polygons,
    two_sided_sheets,
    double_sided_faces,
    non_manifold_edges,
    non_manifold_vertices,
    border_edges,
    crossing_faces,
    crossing_faces_unknown,
    inside_out_parts,
    coplanar_faces,
    coplanar_faces_unknown,
    covered_parts,
    count
};

/// "room.obj:40: ", or "room.obj: " where lines are unknown.
std::string file_prefix(const PolygonSoup& soup, std::uint32_t line);

/// The same for the file and line of a face.
std::string face_prefix(const PolygonSoup& soup, std::size_t face);

/// "face 12 (line 40)"; faces and points are numbered from 0. For a soup assembled from several files: "face 12 (line
/// 40) of room.obj", numbered as in that file.
std::string face_name(const PolygonSoup& soup, std::size_t face);

/// The same for a face of a mesh that has been diagnosed.
std::string face_name(const Diagnosis& diagnosis, std::size_t face);

/// "point 7 (line 9)".
std::string point_name(const PolygonSoup& soup, std::size_t point);

/// Line of a face in the file, 0 if unknown.
std::uint32_t line_of_face(const PolygonSoup& soup, std::size_t face);

/// A finding of `count` defects at these places, of which the first few are kept.
Finding finding_of(Defect defect, std::size_t count, std::vector<std::string> places);

class FindingList {
  public:
    /// The soup must outlive the list.
    explicit FindingList(const PolygonSoup& soup) : soup_(soup) {}

    /// Records a defect at a face near a position.
    void at_face(Defect defect, std::size_t face, const Vec3& position);

    /// Records a defect of two faces that meet near a position.
    void at_faces(Defect defect, std::size_t face, std::size_t other, const Vec3& position);

    /// Records a defect at a point of the file.
    void at_point(Defect defect, std::size_t point);

    std::size_t count(Defect defect) const { return entries_[static_cast<std::size_t>(defect)].count; }

    /// The kinds found.
    std::vector<Finding> findings() const;

  private:
    struct Entry {
        std::size_t count = 0;
        std::vector<std::string> places;
    };
    /// Counts, and returns where to write the place; null if enough places are known.
    std::vector<std::string>* add(Defect defect);

    const PolygonSoup& soup_;
    std::array<Entry, static_cast<std::size_t>(Defect::count)> entries_;
};

} // namespace difusa
