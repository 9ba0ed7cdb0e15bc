// The area of a triangle, and whether it is distinguishable from zero under rounding.
#pragma once

#include <difusa/core/types.h>

#include <cmath>
#include <limits>

namespace difusa {

/// Two edge vectors of a triangle, the shorter ones, in an order such that `first × second` is twice its vector area:
/// their cross product has the smallest rounding error of the three.
struct ShortEdges {
    Vec3 first, second;

    ShortEdges(const Vec3& a, const Vec3& b, const Vec3& c) {
        const Vec3 ab = b - a, bc = c - b, ca = a - c;
        const double ab2 = ab.squaredNorm(), bc2 = bc.squaredNorm(), ca2 = ca.squaredNorm();
        const bool without_ab = ab2 >= bc2 && ab2 >= ca2, without_bc = bc2 >= ab2 && bc2 >= ca2;
        first = without_ab ? bc : without_bc ? ca : ab;
        second = without_ab ? ca : without_bc ? ab : bc;
    }
};

/// Twice the area times the unit normal.
inline Vec3 twice_vector_area(const Vec3& a, const Vec3& b, const Vec3& c) {
    const ShortEdges edges(a, b, c);
    return edges.first.cross(edges.second);
}

/// True if the three points cannot be distinguished from collinear ones.
///
/// Each coordinate of a point is known to half a unit in its last place, so each edge component has an error of up to
/// eps times the largest coordinate of its axis, and the subtraction adds as much; with the rounding of the products,
/// each component of the cross product is off by at most the bound below. A triangle all of whose components are within
/// it has no area. This needs no absolute tolerance, keeps needles (near the origin down to a height of about 1e-15 of
/// their length), and far from the origin is as coarse as the coordinates themselves, axis by axis.
inline bool without_area(const Vec3& a, const Vec3& b, const Vec3& c) {
    const ShortEdges edges(a, b, c);
    const Vec3 cross = edges.first.cross(edges.second);
    const Vec3 largest = a.cwiseAbs().cwiseMax(b.cwiseAbs()).cwiseMax(c.cwiseAbs());
    const Vec3 reach = edges.first.cwiseAbs() + edges.second.cwiseAbs();
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const double bound =
            4.0 * std::numeric_limits<double>::epsilon() * (largest[j] * reach[k] + largest[k] * reach[j]);
        // Below the smallest normal number products lose digits, and the bound does not hold.
        if (std::abs(cross[i]) > bound && std::abs(cross[i]) >= std::numeric_limits<double>::min()) {
            return false;
        }
    }
    return true;
}

} // namespace difusa
