// What is wrong with a mesh file, found, counted, located, and mended or refused.
#pragma once

#include <difusa/scene/mesh.h>
#include <difusa/scene/polygon_soup.h>

#include <string>
#include <vector>

namespace difusa {

/// One kind of defect and what became of it.
struct Finding {
    std::string code;                ///< stable name for reports, for example "zero-area-faces"
    std::size_t count = 0;           ///< how many places
    std::vector<std::string> places; ///< the first few, "face 12 (line 40) near (1, 2, 3)"
    std::string remedy;              ///< what was done, for example "left out"; empty if nothing had to be
    bool repaired = false;           ///< true: the mesh differs from the file; false: only worth knowing

    /// One line for a person: "3 zero-area faces: left out (face 12 (line 40) near (1, 2, 3); ...)".
    std::string message() const;
};

struct Diagnosis {
    std::vector<Finding> findings;
    std::size_t file_faces = 0, file_points = 0;
};

/// A mesh fit for baking, and the report of what it took.
struct DiagnosedMesh {
    Mesh mesh; ///< derived; `material` numbers soup.materials, or equals soup.materials.size() for faces without one
    Diagnosis diagnosis;
};

/// Judges and repairs a soup.
///
/// Refused (InputError naming file, line or face, coordinates and remedy): an index out of range, a coordinate
/// that is NaN or infinite in a used point, a polygon that crosses itself, a reflectance outside [0,1], a
/// negative or non-finite emission, a mesh without any face left.
///
/// Repaired, counted and located: repeated corners (removed), faces with fewer than three distinct corners and
/// zero-area faces (left out), duplicate faces (one kept), duplicate points (merged), unreferenced points (left
/// out), polygons with more than three corners (triangulated; non-planar and concave ones are named),
/// inconsistent orientation inside an edge-connected piece (the minority by area is turned).
///
/// Only reported: non-manifold edges and vertices, border edges, pieces that cannot be oriented (Möbius strip),
/// two faces back to back on the same corners (a two-sided sheet).
DiagnosedMesh diagnose(const PolygonSoup& soup);

} // namespace difusa
