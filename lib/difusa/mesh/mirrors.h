// The faces of a mesh in which one sees others: perfect mirrors, and the specular share of partial ones.
#pragma once

#include <difusa/core/colour.h>
#include <difusa/core/types.h>

#include <algorithm>
#include <vector>

namespace difusa {

/// What rays need to know of mirrors. A mirror reflects on its front, in the plane of its triangle; its back is opaque
/// like any other. Like the shape of the surface, it belongs to the geometry: light transport depends on it.
struct Mirrors {
    std::vector<Index> of_face;   ///< #T: number in `reflectance`, or none; empty: there are no mirrors
    std::vector<Rgb> reflectance; ///< of each kind of mirror: the share of light it reflects specularly, in [0,1]
    std::size_t most = 32;        ///< reflections in a row; light that is reflected specularly more often is cut off

    bool any() const { return !reflectance.empty(); }

    /// The kind of mirror that a triangle is, or none.
    Index kind(Index triangle) const { return any() ? of_face[triangle] : none; }

    bool is_grey() const {
        return std::all_of(reflectance.begin(), reflectance.end(),
                           [](const Rgb& each) { return equal_channels(each); });
    }
};

/// The direction in which a ray goes on after a mirror with the unit normal n; its length is kept.
inline Vec3 mirrored(const Vec3& direction, const Vec3& n) {
    return direction - 2.0 * n.dot(direction) * n;
}

} // namespace difusa
