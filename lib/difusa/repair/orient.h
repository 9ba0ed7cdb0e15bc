// Which faces must be turned over so that neighbours agree on which side is their front.
#pragma once

#include <difusa/mesh/edges.h>

#include <span>
#include <vector>

namespace difusa {

/// An edge that shows that a piece has one side only.
struct OneSidedPiece {
    Index face;      ///< one of the two faces at the edge
    Index low, high; ///< the edge's end points
};

struct Orientation {
    std::vector<char> turned;                    ///< #faces: 1 if the face must be turned
    std::vector<OneSidedPiece> one_sided_pieces; ///< pieces that cannot be oriented, in order of those edges
};

/// Orients pieces of faces that are connected across edges of exactly two triangles. A face is one or more
/// triangles and is turned as a whole.
///
/// In each piece that can be oriented, the faces of the orientation with the lesser area are turned; if the areas
/// are equal (to 1e-9, which covers the rounding of sums), those that disagree with the piece's first face. A piece
/// that cannot be oriented, such as a Möbius strip, keeps all its faces as they are.
///
/// face: #T, the face of each triangle, < face_count; area: #T.
Orientation orient(const Edges& edges, std::span<const Index> face, std::span<const double> area,
                   std::size_t face_count);

} // namespace difusa
