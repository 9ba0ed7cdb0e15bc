// Which faces must be flipped so that neighbours agree on which side is their front.
#pragma once

#include <difusa/mesh/edges.h>

#include <span>
#include <vector>

namespace difusa {

/// An edge showing that a piece is one-sided.
struct OneSidedPiece {
    Index face;      ///< one of the two faces at the edge
    Index low, high; ///< the edge's end points
};

struct Orientation {
    std::vector<char> turned;                    ///< #faces: 1 if the face must be flipped
    std::vector<OneSidedPiece> one_sided_pieces; ///< pieces that cannot be oriented, in order of those edges
};

/// Orients pieces of faces connected across edges of exactly two triangles. A face consists of one or more triangles
/// and is flipped as a whole.
///
/// In each orientable piece, the faces of the orientation with the smaller area are flipped; if the areas are equal (to
/// 1e-9, which covers the rounding of sums), those that disagree with the piece's first face. A piece that cannot be
/// oriented, such as a Möbius strip, keeps all its faces as they are.
///
/// face: #T, the face of each triangle, < face_count; area: #T.
Orientation orient(const Edges& edges, std::span<const Index> face, std::span<const double> area,
                   std::size_t face_count);

} // namespace difusa
