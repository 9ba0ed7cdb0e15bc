#include <difusa/repair/diagnosis.h>

#include <difusa/core/error.h>
#include <difusa/core/text.h>
#include <difusa/mesh/crossing_faces.h>
#include <difusa/mesh/edges.h>
#include <difusa/mesh/outline.h>
#include <difusa/mesh/triangle_area.h>
#include <difusa/mesh/triangulate.h>
#include <difusa/repair/findings.h>
#include <difusa/repair/merge_points.h>
#include <difusa/repair/orient.h>
#include <difusa/repair/soup_check.h>
#include <difusa/repair/texture_coordinates.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <tuple>

namespace difusa {

namespace {

/// Below it products of two areas underflow.
constexpr double least_size = 1e-75;

/// The triangles on their way from the file to the mesh. Corners are numbers of points and corners of the file.
struct CutFaces {
    std::vector<std::array<Corner, 3>> corners;
    std::vector<Index> face; ///< number in the file, ascending

    std::size_t size() const { return corners.size(); }
};

/// The points a face of the file uses.
std::vector<char> used_points(const PolygonSoup& soup) {
    std::vector<char> used(soup.points.size(), 0);
    for (const Index corner : soup.corners) {
        used[corner] = 1;
    }
    return used;
}

[[noreturn]] void refuse_crossing(const PolygonSoup& soup, std::size_t face, const Vec3& place) {
    throw InputError(face_prefix(soup, face) + face_name(soup, face) + " crosses itself near " + coordinates(place) +
                     ". Correct the order of its corners, or cut it into triangles.");
}

/// Splits all faces into triangles of nonzero area.
CutFaces cut_faces(const PolygonSoup& soup, const std::vector<Index>& place, FindingList& found) {
    CutFaces result;
    result.corners.reserve(soup.corners.size());
    result.face.reserve(soup.corners.size());
    Outline outline;
    std::vector<Vec3> corners;
    for (std::size_t f = 0; f < soup.face_count(); ++f) {
        const auto face = soup.face(f);
        const Vec3 where = face.empty() ? Vec3(Vec3::Zero()) : soup.points[face[0]];
        outline.clear();
        for (std::size_t c = soup.first_corner[f]; c < soup.first_corner[f + 1]; ++c) {
            outline.push_back({place[soup.corners[c]], static_cast<Index>(c)});
        }
        const std::size_t places = distinct_places(outline);
        remove_repetitions(outline);
        if (outline.size() < 3) {
            found.at_face(places < 3 ? Defect::too_few_corners : Defect::zero_area_faces, f, where);
            continue;
        }
        // Faces on the same corners must be split the same way, whatever corner and direction they start with.
        const bool reversed = outline.size() > 3 && make_canonical(outline);
        corners.clear();
        for (const Corner& corner : outline) {
            corners.push_back(soup.points[corner.place]);
        }
        const Triangulation cut = triangulate(corners);
        if (cut.outcome == Triangulation::Outcome::crosses_itself) {
            refuse_crossing(soup, f, cut.place);
        }
        const std::size_t before = result.size();
        std::size_t without = 0;
        for (const auto& [a, b, c] : cut.triangles) {
            if (without_area(corners[a], corners[b], corners[c])) {
                ++without;
                continue;
            }
            result.corners.push_back({outline[a], outline[reversed ? c : b], outline[reversed ? b : c]});
            result.face.push_back(static_cast<Index>(f));
        }
        if (result.size() == before) {
            found.at_face(Defect::zero_area_faces, f, where);
            continue;
        }
        for (; without > 0; --without) {
            found.at_face(Defect::zero_area_pieces, f, where);
        }
        if (outline.size() < face.size()) {
            found.at_face(Defect::repeated_corners, f, where);
        }
        if (outline.size() > 3) {
            found.at_face(Defect::polygons, f, where);
        }
        if (cut.concave) {
            found.at_face(Defect::concave_polygons, f, where);
        }
        if (!cut.planar) {
            found.at_face(Defect::non_planar_polygons, f, where);
        }
    }
    return result;
}

/// Of triangles on the same corners with the same orientation keeps the first that emits light, or the first; reports
/// those of other materials than theirs, and those back to back with an earlier one.
void remove_duplicates(const PolygonSoup& soup, CutFaces& triangles, FindingList& found) {
    struct Entry {
        std::array<Index, 3> place; ///< ascending
        Index triangle;
        bool odd; ///< the corners run in the opposite order
    };
    std::vector<Entry> entries;
    entries.reserve(triangles.size());
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const auto& [a, b, c] = triangles.corners[t];
        Entry entry{{a.place, b.place, c.place}, static_cast<Index>(t), false};
        const bool odd = (a.place > b.place) != ((a.place > c.place) != (b.place > c.place));
        std::sort(entry.place.begin(), entry.place.end());
        entry.odd = odd;
        entries.push_back(entry);
    }
    std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
        return std::tie(a.place, a.triangle) < std::tie(b.place, b.triangle);
    });
    const auto material = [&](Index t) { return soup.face_material[triangles.face[t]]; };
    const auto emits = [&](Index t) {
        return material(t) != none && (soup.materials[material(t)].emission > 0.0).any();
    };
    std::vector<Index> kept_for(triangles.size()); // itself, or the one that it repeats
    std::vector<char> back_to_back(triangles.size(), 0);
    for (std::size_t i = 0; i < entries.size();) {
        std::size_t end = i;
        std::array<Index, 2> kept{none, none};
        for (; end < entries.size() && entries[end].place == entries[i].place; ++end) {
            Index& own = kept[entries[end].odd ? 1 : 0];
            if (own == none || (emits(entries[end].triangle) && !emits(own))) {
                own = entries[end].triangle;
            }
        }
        for (; i < end; ++i) {
            const auto [place, triangle, odd] = entries[i];
            kept_for[triangle] = kept[odd ? 1 : 0];
            const Index back = kept[odd ? 0 : 1];
            back_to_back[triangle] = back != none && back < triangle ? 1 : 0;
        }
    }

    // Face by face: a face all of whose triangles repeat others is a duplicate.
    CutFaces kept;
    for (std::size_t begin = 0; begin < triangles.size();) {
        const Index face = triangles.face[begin];
        std::size_t end = begin, repeated = 0;
        bool sheet = false;
        Index other = none; // that is kept, of another material
        for (; end < triangles.size() && triangles.face[end] == face; ++end) {
            if (kept_for[end] != end) {
                ++repeated;
                other = material(kept_for[end]) != material(static_cast<Index>(end)) ? kept_for[end] : other;
                continue;
            }
            sheet = sheet || back_to_back[end] != 0;
            kept.corners.push_back(triangles.corners[end]);
            kept.face.push_back(face);
        }
        const Vec3& where = soup.points[triangles.corners[begin][0].place];
        if (repeated == end - begin) {
            found.at_face(Defect::duplicate_faces, face, where);
        } else {
            for (; repeated > 0; --repeated) {
                found.at_face(Defect::duplicate_pieces, face, where);
            }
        }
        if (other != none) {
            found.at_faces(Defect::duplicate_materials, face, triangles.face[other], where);
        }
        if (sheet) {
            found.at_face(Defect::two_sided_sheets, face, where);
        }
        begin = end;
    }
    triangles = std::move(kept);
}

/// What to do if no face has an area: numbers may not have enough digits for them.
std::string remedy(const PolygonSoup& soup) {
    Eigen::AlignedBox3d box;
    for (const Index corner : soup.corners) {
        box.extend(soup.points[corner]);
    }
    const double size = box.diagonal().stableNorm(),
                 most = box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).maxCoeff();
    if (size < 0x1p-30 * most) {
        return "The mesh is " + text_of(size) + " across, at coordinates up to " + text_of(most) +
               ", which leave too few digits for it: move it to the origin.";
    }
    if (size == 0.0) {
        return "All points of the mesh are in the same place.";
    }
    return size < least_size
               ? "The mesh is " + text_of(size) + " across; areas of that size underflow: use a smaller unit of length."
               : "Correct these faces.";
}

/// Rejects a mesh without faces, and says what became of them.
void refuse_empty(const PolygonSoup& soup, const FindingList& found) {
    std::string message = file_prefix(soup, 0);
    if (soup.face_count() == 0) {
        message += "has no faces (" + std::to_string(soup.points.size()) + " points).";
        for (const std::string& note : soup.notes) { // what was skipped
            message += " " + note + ".";
        }
        throw InputError(message + " There is nothing to bake: give a mesh with polygons.");
    }
    message += soup.face_count() == 1 ? "its only face cannot be baked."
                                      : "none of its " + std::to_string(soup.face_count()) + " faces can be baked.";
    for (const Finding& finding : found.findings()) {
        message += " " + finding.message() + ".";
    }
    throw InputError(message + " " + remedy(soup));
}

/// Points, triangles, materials and colours of the mesh, in the order of the file.
Mesh make_mesh(const PolygonSoup& soup, const CutFaces& triangles, const std::vector<char>& used,
               const std::vector<Index>& place, FindingList& found) {
    std::vector<Index> number(soup.points.size(), none);
    for (const auto& triangle : triangles.corners) {
        for (const Corner& corner : triangle) {
            number[corner.place] = 0;
        }
    }
    Mesh mesh;
    for (std::size_t p = 0; p < soup.points.size(); ++p) {
        if (used[p] == 0) {
            found.at_point(Defect::unreferenced_points, p);
        } else if (place[p] != p) {
            found.at_point(Defect::duplicate_points, p);
        } else if (number[p] == none) {
            found.at_point(Defect::orphaned_points, p);
        } else {
            number[p] = static_cast<Index>(mesh.points.size());
            mesh.points.push_back(soup.points[p]);
        }
    }
    const auto unnamed = static_cast<Index>(soup.materials.size());
    bool coloured = false, textured = false;
    mesh.triangles.reserve(triangles.size());
    mesh.material.reserve(triangles.size());
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const auto& [a, b, c] = triangles.corners[t];
        mesh.triangles.push_back({number[a.place], number[b.place], number[c.place]});
        const Index material = soup.face_material[triangles.face[t]];
        mesh.material.push_back(material == none ? unnamed : material);
        coloured = coloured || soup.painted(triangles.face[t]);
        textured = textured || (material != none && is_textured(soup.materials[material]));
    }
    mesh.original_face = triangles.face;
    if (coloured) {
        mesh.corner_reflectance.assign(triangles.size(), {Rgb::Zero(), Rgb::Zero(), Rgb::Zero()});
        for (std::size_t t = 0; t < triangles.size(); ++t) {
            if (soup.painted(triangles.face[t])) {
                for (std::size_t k = 0; k < 3; ++k) {
                    mesh.corner_reflectance[t][k] =
                        soup.point_reflectance[soup.corners[triangles.corners[t][k].source]];
                }
            }
        }
    }
    if (textured) {
        const TextureCoordinates zero = TextureCoordinates::Zero();
        mesh.corner_texture.assign(triangles.size(), {zero, zero, zero});
        for (std::size_t t = 0; t < triangles.size(); ++t) {
            const Index material = soup.face_material[triangles.face[t]];
            if (material != none && is_textured(soup.materials[material])) {
                for (std::size_t k = 0; k < 3; ++k) {
                    mesh.corner_texture[t][k] = soup.corner_texture[triangles.corners[t][k].source];
                }
            }
        }
    }
    return mesh;
}

/// Flips faces so that neighbours agree, and reports where they cannot.
void orient_faces(const PolygonSoup& soup, const Edges& edges, Mesh& mesh, FindingList& found) {
    std::vector<double> area;
    area.reserve(mesh.triangles.size());
    for (const auto& [a, b, c] : mesh.triangles) {
        area.push_back(0.5 * twice_vector_area(mesh.points[a], mesh.points[b], mesh.points[c]).stableNorm());
    }
    const Orientation orientation = orient(edges, mesh.original_face, area, soup.face_count());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const Index face = mesh.original_face[t];
        if (orientation.turned[face] == 0) {
            continue;
        }
        mesh.turn_over(static_cast<Index>(t));
        if (t == 0 || mesh.original_face[t - 1] != face) {
            found.at_face(Defect::inconsistent_orientation, face, mesh.corner(static_cast<Index>(t), 0));
        }
    }
    for (const OneSidedPiece& piece : orientation.one_sided_pieces) {
        found.at_face(Defect::one_sided_pieces, piece.face, 0.5 * (mesh.points[piece.low] + mesh.points[piece.high]));
    }
}

/// Reports borders, and non-manifold edges and vertices.
void report_topology(const Edges& edges, const Mesh& mesh, FindingList& found) {
    edges.for_each([&](Index low, Index high, std::span<const EdgeSide> sides) {
        if (sides.size() != 2) {
            found.at_face(sides.size() == 1 ? Defect::border_edges : Defect::non_manifold_edges,
                          mesh.original_face[sides[0].triangle], 0.5 * (mesh.points[low] + mesh.points[high]));
        }
    });
    const std::vector<Index> touching = non_manifold_points(edges, mesh.triangles, mesh.points.size());
    if (touching.empty()) {
        return;
    }
    std::vector<Index> face(mesh.points.size(), none); // the first at each point
    for (std::size_t t = mesh.triangles.size(); t-- > 0;) {
        for (const Index point : mesh.triangles[t]) {
            face[point] = mesh.original_face[t];
        }
    }
    for (const Index point : touching) {
        found.at_face(Defect::non_manifold_vertices, face[point], mesh.points[point]);
    }
}

/// Reports faces that pass through each other; each pair once, however many of their triangles do.
void report_crossings(const Mesh& mesh, FindingList& found, const Execution& execution) {
    const auto faces = [&](const std::array<Index, 2>& pair) {
        return std::array<Index, 2>{mesh.original_face[pair[0]], mesh.original_face[pair[1]]};
    };
    auto all = find_crossing_triangles(mesh, execution);
    if (!all) {
        found.at_face(Defect::crossing_faces_unknown, mesh.original_face[0], mesh.corner(0, 0));
        return;
    }
    std::vector<std::array<Index, 2>>& pairs = *all;
    std::stable_sort(pairs.begin(), pairs.end(), [&](const auto& a, const auto& b) { return faces(a) < faces(b); });
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        const auto [face, other] = faces(pairs[i]);
        if (i == 0 || faces(pairs[i - 1]) != faces(pairs[i])) {
            found.at_faces(Defect::crossing_faces, face, other,
                           middle_of_crossing(mesh.corners(pairs[i][0]), mesh.corners(pairs[i][1])));
        }
    }
}

/// The corners of a triangle, starting at the lowest number: equal for triangles with the same corners and the same
/// front.
std::array<Index, 3> from_least(std::array<Index, 3> corners) {
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    return corners;
}

/// Gives each triangle of a double-sided material a second one as its back, unless there is one already.
void add_backs(const PolygonSoup& soup, Mesh& mesh, FindingList& found) {
    const std::size_t count = mesh.triangles.size();
    const auto double_sided = [&](std::size_t t) {
        return mesh.material[t] < soup.materials.size() && soup.materials[mesh.material[t]].double_sided;
    };
    std::vector<std::array<Index, 3>> fronts;
    for (std::size_t t = 0; t < count; ++t) {
        if (double_sided(t)) {
            fronts.push_back(from_least(mesh.triangles[t]));
        }
    }
    if (fronts.empty()) {
        return;
    }
    fronts.clear();
    for (const auto& triangle : mesh.triangles) {
        fronts.push_back(from_least(triangle));
    }
    std::sort(fronts.begin(), fronts.end());
    for (std::size_t t = 0; t < count; ++t) {
        if (!double_sided(t)) {
            continue;
        }
        const auto [a, b, c] = mesh.triangles[t];
        const Index face = mesh.original_face[t];
        if (t == 0 || mesh.original_face[t - 1] != face) {
            found.at_face(Defect::double_sided_faces, face, mesh.points[a]);
        }
        if (std::binary_search(fronts.begin(), fronts.end(), from_least({a, c, b}))) {
            continue;
        }
        mesh.triangles.push_back({a, b, c});
        mesh.original_face.push_back(face);
        mesh.material.push_back(Index{mesh.material[t]});
        if (!mesh.corner_reflectance.empty()) {
            mesh.corner_reflectance.push_back(std::array<Rgb, 3>(mesh.corner_reflectance[t]));
        }
        if (!mesh.corner_texture.empty()) {
            mesh.corner_texture.push_back(std::array<TextureCoordinates, 3>(mesh.corner_texture[t]));
        }
        mesh.turn_over(static_cast<Index>(mesh.triangles.size() - 1));
    }
}

} // namespace

DiagnosedMesh diagnose(const PolygonSoup& soup, const Execution& execution) {
    FindingList found(soup);

    // 1. What no repair could guess is rejected.
    check_soup(soup);

    // 2. Coincident points are merged, so that faces that touch are connected.
    const std::vector<char> used = used_points(soup);
    const std::vector<Index> place = first_at_place(soup.points, used);

    execution.check();
    // 3. Faces become triangles of nonzero area, each of them once.
    CutFaces triangles = cut_faces(soup, place, found);
    remove_duplicates(soup, triangles, found);
    if (triangles.size() == 0) {
        refuse_empty(soup, found);
    }
    DiagnosedMesh result;
    result.mesh = make_mesh(soup, triangles, used, place, found);

    execution.check();
    // 4. Neighbours agree on their fronts. Flipping a face changes no edge, only the direction it is traversed in.
    const Edges edges(result.mesh.triangles, result.mesh.points.size());
    orient_faces(soup, edges, result.mesh, found);
    report_topology(edges, result.mesh, found);
    report_crossings(result.mesh, found, execution);

    execution.check();
    // 5. Backs that act as fronts too. Nothing above treats them as defects.
    add_backs(soup, result.mesh, found);

    result.mesh.derive();
    result.diagnosis = {found.findings(), soup.face_count(), soup.points.size(), soup.parts, soup.face_line};
    return result;
}

} // namespace difusa
