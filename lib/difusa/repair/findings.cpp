#include <difusa/repair/findings.h>

#include <difusa/core/text.h>

#include <algorithm>
#include <sstream>
#include <utility>

namespace difusa {

namespace {

constexpr std::size_t places_kept = 3;

struct Wording {
    const char* code;
    const char* one;
    const char* many;
    const char* remedy;
    bool repaired;
};

/// In the order of `Defect`.
constexpr std::array<Wording, static_cast<std::size_t>(Defect::count)> wordings{{
    {"repeated-corners", "face with repeated corners", "faces with repeated corners", "repetitions removed", true},
    {"too-few-corners", "face with fewer than three distinct corners", "faces with fewer than three distinct corners",
     "left out", true},
    {"zero-area-faces", "zero-area face", "zero-area faces", "left out", true},
    {"zero-area-pieces", "zero-area triangle of a polygon", "zero-area triangles of polygons", "left out", true},
    {"duplicate-faces", "duplicate face", "duplicate faces",
     "left out, the first of each kept, or the first that emits light", true},
    {"duplicate-pieces", "triangle of a polygon duplicating another face",
     "triangles of polygons duplicating other faces", "left out, the first of each kept, or the first that emits light",
     true},
    {"duplicate-materials", "duplicate face of another material than the one that is kept",
     "duplicate faces of other materials than those that are kept", "", false},
    {"duplicate-points", "point coinciding with another", "points coinciding with others", "merged", true},
    {"unreferenced-points", "point without a face", "points without a face", "left out", true},
    {"orphaned-points", "point of left-out faces only", "points of left-out faces only", "left out", true},
    {"inconsistent-orientation", "face oriented against its neighbours", "faces oriented against their neighbours",
     "turned over", true},
    {"one-sided-pieces", "piece of the surface that cannot be oriented (like a Möbius strip)",
     "pieces of the surface that cannot be oriented (like a Möbius strip)",
     "left as they are: their fronts change sides somewhere", false},
    {"non-planar-polygons", "non-planar polygon", "non-planar polygons",
     "cut into triangles, which define the surface between the corners", true},
    {"concave-polygons", "concave polygon", "concave polygons", "cut into triangles", false},
    {"polygons", "polygon with more than three corners", "polygons with more than three corners", "cut into triangles",
     false},
    {"two-sided-sheets", "face back to back with another", "faces back to back with others", "", false},
    {"double-sided-faces", "face of a double-sided material", "faces of double-sided materials",
     "their backs act as fronts too", false},
    {"non-manifold-edges", "edge of three or more triangles", "edges of three or more triangles", "", false},
    {"non-manifold-vertices", "vertex where separate parts touch", "vertices where separate parts touch", "", false},
    {"border-edges", "border edge", "border edges", "", false},
    {"crossing-faces", "pair of crossing faces", "pairs of crossing faces", "", false},
    {"crossing-faces-unknown", "search for crossing faces", "searches for crossing faces",
     "given up, since too many are close together", false},
    {"inside-out-parts", "connected part inside out", "connected parts inside out", "turned over", true},
    {"coplanar-faces", "face on another one in the same plane", "faces on others in the same plane",
     "moved by a hair: smaller faces to the front, those of closed bodies into them", true},
    {"coplanar-faces-unknown", "search for faces on others in the same plane",
     "searches for faces on others in the same plane",
     "given up, since too many faces are close together, or at a symmetry plane or period", false},
    {"covered-parts", "face covered, at least in part, by another one in the same plane",
     "faces covered, at least in part, by others in the same plane", "what is covered was left out", true},
}};

std::string with_line(const char* kind, std::size_t number, std::uint32_t line) {
    std::string name = kind + std::to_string(number);
    if (line != 0) {
        name += " (line " + std::to_string(line) + ")";
    }
    return name;
}

} // namespace

std::string file_prefix(const PolygonSoup& soup, std::uint32_t line) {
    return soup.file + (line != 0 ? ":" + std::to_string(line) : "") + ": ";
}

namespace {

/// The part that `number` belongs to by its `first`; null if there is only one file.
const SoupPart* part_of(const std::vector<SoupPart>& parts, std::size_t SoupPart::*first, std::size_t number) {
    const auto next = std::upper_bound(parts.begin(), parts.end(), number,
                                       [&](std::size_t n, const SoupPart& part) { return n < part.*first; });
    return next == parts.begin() ? nullptr : &*std::prev(next);
}

std::string name_in_part(const std::vector<SoupPart>& parts, const char* kind, std::size_t SoupPart::*first,
                         std::size_t number, std::uint32_t line) {
    const SoupPart* part = part_of(parts, first, number);
    return part == nullptr ? with_line(kind, number, line)
                           : with_line(kind, number - part->*first, line) + " of " + part->file;
}

} // namespace

std::string face_prefix(const PolygonSoup& soup, std::size_t face) {
    const SoupPart* part = part_of(soup.parts, &SoupPart::first_face, face);
    const std::uint32_t line = line_of_face(soup, face);
    return (part == nullptr ? soup.file : part->file) + (line != 0 ? ":" + std::to_string(line) : "") + ": ";
}

std::uint32_t line_of_face(const PolygonSoup& soup, std::size_t face) {
    return face < soup.face_line.size() ? soup.face_line[face] : 0;
}

std::string face_name(const PolygonSoup& soup, std::size_t face) {
    return name_in_part(soup.parts, "face ", &SoupPart::first_face, face, line_of_face(soup, face));
}

std::string face_name(const Diagnosis& diagnosis, std::size_t face) {
    return name_in_part(diagnosis.parts, "face ", &SoupPart::first_face, face,
                        face < diagnosis.face_line.size() ? diagnosis.face_line[face] : 0);
}

std::string point_name(const PolygonSoup& soup, std::size_t point) {
    return name_in_part(soup.parts, "point ", &SoupPart::first_point, point,
                        point < soup.point_line.size() ? soup.point_line[point] : 0);
}

std::vector<std::string>* FindingList::add(Defect defect) {
    Entry& entry = entries_[static_cast<std::size_t>(defect)];
    ++entry.count;
    return entry.places.size() < places_kept ? &entry.places : nullptr;
}

void FindingList::at_face(Defect defect, std::size_t face, const Vec3& position) {
    if (auto* places = add(defect)) {
        places->push_back(face_name(soup_, face) + " near " + coordinates(position));
    }
}

void FindingList::at_faces(Defect defect, std::size_t face, std::size_t other, const Vec3& position) {
    if (auto* places = add(defect)) {
        places->push_back(face_name(soup_, face) + " and " + face_name(soup_, other) + " near " +
                          coordinates(position));
    }
}

void FindingList::at_point(Defect defect, std::size_t point) {
    if (auto* places = add(defect)) {
        places->push_back(point_name(soup_, point) + " at " + coordinates(soup_.points[point]));
    }
}

std::vector<Finding> FindingList::findings() const {
    std::vector<Finding> found;
    for (std::size_t d = 0; d < entries_.size(); ++d) {
        if (entries_[d].count > 0) {
            found.push_back(finding_of(static_cast<Defect>(d), entries_[d].count, entries_[d].places));
        }
    }
    return found;
}

Finding finding_of(Defect defect, std::size_t count, std::vector<std::string> places) {
    const Wording& wording = wordings[static_cast<std::size_t>(defect)];
    places.resize(std::min(places.size(), places_kept));
    return {wording.code, count, std::move(places), wording.remedy, wording.repaired};
}

std::string Finding::message() const {
    const auto wording =
        std::find_if(wordings.begin(), wordings.end(), [this](const Wording& w) { return w.code == code; });
    std::string text = std::to_string(count) + " ";
    text += wording == wordings.end() ? code : count == 1 ? wording->one : wording->many;
    if (!remedy.empty()) {
        text += ": " + remedy;
    }
    if (!places.empty()) {
        text += " (";
        for (std::size_t i = 0; i < places.size(); ++i) {
            text += (i == 0 ? "" : "; ") + places[i];
        }
        text += count > places.size() ? "; ...)" : ")";
    }
    return text;
}

std::string Finding::remark() const {
    if (!repaired && (code == "polygons" || code == "border-edges")) {
        return "";
    }
    return (repaired ? "repaired: " : "noticed: ") + message();
}

} // namespace difusa
