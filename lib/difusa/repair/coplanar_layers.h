// Faces that overlap others in the same plane: which of them is in front, and which stand on each other.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/mesh/mesh.h>
#include <difusa/repair/findings.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace difusa {

/// How far coplanar faces of a mesh are set apart.
struct CoplanarDistances {
    double layer = 0.0; ///< between faces with the same front: 2^-20 of the diameter
    double gap = 0.0;   ///< between bodies and what they stand on: 2^-22 of it. Both are larger far from the origin

    CoplanarDistances() = default;
    explicit CoplanarDistances(const Mesh& mesh);

    /// Heights that count as none, such as those of single precision.
    double rounding() const;
};

/// Two triangles in one plane, and the part that they have in common.
struct Overlap {
    Index a, b;
    bool same_front;
    double area;
    Vec3 place;
};

/// All of them, by their triangles, but for overlaps of less than a thousandth of the smaller triangle; nothing if the
/// boxes of more than a million pairs of triangles and 100 of each triangle touch. Throws Interrupted.
std::optional<std::vector<Overlap>> find_overlaps(const Mesh& mesh, double rounding, const Execution& execution);

/// A face that is moved or cut because of another one, both by their numbers in the file.
struct CoplanarFace {
    Index face, other;
    Vec3 place; ///< where they overlap
};

/// "face 12 (line 40) on face 3 (line 9) near (1, 2, 3)"; `relation`: such as " on ".
std::string place_of(const CoplanarFace& face, const char* relation, const Diagnosis& diagnosis);

/// What a user should know of faces that were moved (Defect::coplanar_faces) or cut (Defect::covered_parts), if
/// anything. `given_up`: whether there may be others.
std::vector<Finding> findings_of(Defect defect, const std::vector<CoplanarFace>& faces, bool given_up,
                                 const Diagnosis& diagnosis);

/// Triangles in sets, numbered from 0 in the order of their first members.
struct NumberedSets {
    std::vector<Index> of; ///< #triangles
    std::size_t count = 0;
};

/// The triangles as they hang together, and how far each flat patch of them is moved along its normal:
///
/// - Of two patches with the same front, the smaller is put in front, one layer after the other. Else chance would
///   decide which of them a ray meets, and both would take up the light. What counts is the area of all that continues
///   a face in its plane, and of the faces of its material that lie under the same other face, such as tiles. Of
///   patches that are alike in size, the later one is in front, unless a third is between them.
/// - A face of a closed body (its fronts outside) that lies on the front of a single sheet which goes on beyond it is
///   drawn into the body, by a gap. Else it would see what is behind the sheet: locally the two are like the sides of a
///   wall without thickness.
///
/// Where two bodies touch, the faces see nothing but the backs of these bodies, and stay together, as do all others
/// with opposite fronts: they are the two sides of a sheet.
class CoplanarLayers {
  public:
    CoplanarLayers(const Mesh& mesh, const CoplanarDistances& distances, const std::vector<Overlap>& overlaps);

    Index patch(Index t) const { return patches_.of[t]; }
    std::size_t patch_count() const { return patches_.count; }

    /// Along the normal of the triangle.
    double shift(Index t) const { return shift_[patch(t)]; }

    /// Whether a body's face touches there what it stands on, or another body.
    bool is_contact(const Overlap& overlap) const;

    /// The one of two triangles that is behind the other, which has the same front; none if neither is.
    Index covered_one(const Overlap& overlap) const;

    /// Corners move with those of the same number that are at the same point: the triangles of a part, or of the sheet
    /// that this part is a side of; but a patch that lies on another one of its part moves alone.
    std::vector<Index> groups(const std::vector<Overlap>& overlaps) const;

  private:
    NumberedSets joined(bool within_planes) const;
    template <class Act> void for_each_twin(const Act& act) const;
    void find_bodies();
    void find_backs();
    void find_contacts(const std::vector<Overlap>& overlaps);
    bool is_body(Index t) const { return is_body_[parts_.of[t]] != 0; }
    std::vector<double> areas_with_tiles(const std::vector<std::pair<Index, Index>>& pairs) const;
    std::vector<std::pair<Index, Index>> pairs_with_same_front(const std::vector<Overlap>& overlaps) const;
    void put_in_front(const std::vector<std::pair<Index, Index>>& pairs);

    const Mesh& mesh_;
    const CoplanarDistances distances_;
    const std::vector<Index> twin_; ///< where the surface continues, seen from its back
    const NumberedSets parts_, patches_;
    std::vector<char> is_body_;                     ///< #parts
    std::vector<double> area_;                      ///< #patches
    std::vector<double> shift_;                     ///< #patches
    std::vector<Index> back_;                       ///< #patches: the other side of a sheet, or none
    std::vector<char> stands_;                      ///< #patches: drawn into its body
    std::vector<std::pair<Index, Index>> sheets_;   ///< triangles
    std::vector<std::pair<Index, Index>> contacts_; ///< sorted: patches that are drawn in, and what they stand on
};

} // namespace difusa
