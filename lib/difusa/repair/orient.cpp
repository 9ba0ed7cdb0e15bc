#include <difusa/repair/orient.h>

#include <difusa/mesh/parity_sets.h>

#include <cmath>

namespace difusa {

Orientation orient(const Edges& edges, std::span<const Index> face, std::span<const double> area,
                   std::size_t face_count) {
    // 1. Two triangles that run along their edge in the same direction face opposite ways.
    ParitySets pieces(face_count);
    std::vector<OneSidedPiece> contradictions;
    edges.for_each([&](Index low, Index high, std::span<const EdgeSide> sides) {
        if (sides.size() != 2) {
            return;
        }
        const Index a = face[sides[0].triangle], b = face[sides[1].triangle];
        if (a != b && !pieces.join(a, b, sides[0].forward == sides[1].forward)) {
            contradictions.push_back({a, low, high});
        }
    });

    // 2. One contradiction makes a piece one-sided.
    Orientation result;
    result.turned.assign(face_count, 0);
    std::vector<char> one_sided(face_count, 0);
    for (const OneSidedPiece& contradiction : contradictions) {
        char& known = one_sided[pieces.find(contradiction.face).root];
        if (known == 0) {
            known = 1;
            result.one_sided_pieces.push_back(contradiction);
        }
    }

    // 3. The area of either orientation in each piece, and the orientation of its first face.
    struct Balance {
        double same = 0.0, opposite = 0.0;
        bool met = false, first_opposite = false;
    };
    std::vector<Balance> balance(face_count);
    for (std::size_t t = 0; t < face.size(); ++t) {
        const ParitySets::Place place = pieces.find(face[t]);
        Balance& piece = balance[place.root];
        (place.opposite ? piece.opposite : piece.same) += area[t];
        if (!piece.met) {
            piece.met = true;
            piece.first_opposite = place.opposite;
        }
    }

    // 4. The smaller one is flipped.
    for (std::size_t f = 0; f < face_count; ++f) {
        const ParitySets::Place place = pieces.find(static_cast<Index>(f));
        const Balance& piece = balance[place.root];
        const bool equal = std::abs(piece.same - piece.opposite) <= 1e-9 * (piece.same + piece.opposite);
        const bool keep_opposite = equal ? piece.first_opposite : piece.opposite > piece.same;
        if (piece.met && one_sided[place.root] == 0 && place.opposite != keep_opposite) {
            result.turned[f] = 1;
        }
    }
    return result;
}

} // namespace difusa
