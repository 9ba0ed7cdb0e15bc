// The defects of a mesh file: found, counted, located, and repaired or rejected.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/mesh/mesh.h>
#include <difusa/repair/polygon_soup.h>

#include <cstdint>
#include <string>
#include <vector>

namespace difusa {

/// One kind of defect and what became of it.
struct Finding {
    std::string code;                ///< stable name for reports, see the list at `diagnose`
    std::size_t count = 0;           ///< how many occurrences
    std::vector<std::string> places; ///< the first three, "face 12 (line 40) near (1, 2, 3)"; numbers from 0
    std::string remedy;              ///< what was done, for example "left out"; empty if nothing was needed
    bool repaired = false;           ///< true: the surface differs from the file; false: only worth knowing

    /// One line for the user: "3 zero-area faces: left out (face 12 (line 40) near (1, 2, 3); ...)".
    std::string message() const;

    /// The same after "repaired: " or "noticed: "; empty for polygons and borders, which are no defects.
    std::string remark() const;
};

struct Diagnosis {
    std::vector<Finding> findings; ///< each code at most once, in the order of the list at `diagnose`
    std::size_t file_faces = 0, file_points = 0;
    std::vector<SoupPart> parts;          ///< the mesh files of a scene file; empty for a single mesh file
    std::vector<std::uint32_t> face_line; ///< PolygonSoup::face_line
};

/// A mesh fit for baking, and the report of its repairs.
struct DiagnosedMesh {
    Mesh mesh; ///< derived; `material` numbers soup.materials, or equals soup.materials.size() for faces without one.
               ///< The triangles of the file are followed by the backs of those with double-sided materials
    Diagnosis diagnosis;
};

/// Checks and repairs a soup. Points and triangles of the mesh are in the order of the file; the backs added for
/// double-sided materials come last.
///
/// Rejected (InputError naming file, line or face, coordinates and remedy): an index out of range; in a used point, a
/// coordinate that is NaN, infinite or beyond 1e75; a polygon that crosses itself; in a used material or vertex colour,
/// a reflectance outside [0,1] or a negative or non-finite emission; a mesh left without any face. ResourceError: more
/// than 1.4e9 corners.
///
/// Repaired:
///   repeated-corners          faces with corners at the position of the one before, or sides that run out and straight
///                             back: these are removed
///   too-few-corners           faces with fewer than three distinct corners: left out
///   zero-area-faces           faces whose corners are collinear to within the rounding of their coordinates: left out
///   zero-area-pieces          triangles of polygons for which the same holds: left out
///   duplicate-faces           faces on the same corners as others, with the same front: left out but for the first, or
///                             the first that emits light
///   duplicate-pieces          triangles of polygons that repeat part of another face in this way: likewise
///   duplicate-points          points at exactly the position of earlier ones: merged (colours stay with the corners)
///   unreferenced-points       points used by no face: left out, whatever their coordinates
///   orphaned-points           points of faces that were left out: left out
///   inconsistent-orientation  faces oriented against the rest of the piece they are connected to across edges of two
///                             triangles: those with the smaller total area are turned over
///   non-planar-polygons       corners farther from the mean plane than 1e-6 of the diameter: cut into triangles
///
/// Only reported:
///   duplicate-materials       duplicates whose materials differ from those of the faces that are kept
///   one-sided-pieces          pieces that cannot be oriented (Möbius strip)
///   concave-polygons          cut into triangles
///   polygons                  all faces with more than three corners: cut into triangles
///   two-sided-sheets          faces on the same corners as earlier ones, with the opposite front: both kept
///   double-sided-faces        faces of double-sided materials: each triangle gets a second one as its back, unless the
///                             file has it already
///   non-manifold-edges        edges of three or more triangles
///   non-manifold-vertices     vertices where parts touch that share no edge there
///   border-edges              edges of one triangle
///   crossing-faces            pairs of faces that pass through each other (mesh/crossing_faces.h); not coplanar faces
///                             that overlap, nor faces that stand on each other
///   crossing-faces-unknown    crossing faces were not searched for, as too many are close together
///
/// Faces that overlap others in the same plane are left to set_apart (repair/coplanar_faces.h), once their fronts are
/// settled; it may add points.
///
/// Nothing disappears uncounted: the faces of the file are those with triangles in the mesh plus those counted under
/// too-few-corners, zero-area-faces and duplicate-faces; the points of the file are those of the mesh plus
/// duplicate-points, unreferenced-points and orphaned-points. Throws Interrupted.
DiagnosedMesh diagnose(const PolygonSoup& soup, const Execution& execution = {});

} // namespace difusa
