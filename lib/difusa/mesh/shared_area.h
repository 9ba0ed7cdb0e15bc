// Whether triangles in one plane overlap.
#pragma once

#include <difusa/core/types.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cstddef>

namespace difusa {

/// Whether two triangles in one plane with the unit normal n share area: no side of one has the other outside, or
/// reaching over it by no more than `rounding`, as neighbours do.
inline bool share_area(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b, const Vec3& n, double rounding) {
    const auto has_outside = [&](const std::array<Vec3, 3>& p, const Vec3& up, const std::array<Vec3, 3>& q) {
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3 inwards = up.cross(p[(k + 1) % 3] - p[k]).normalized();
            if (std::all_of(q.begin(), q.end(), [&](const Vec3& c) { return inwards.dot(c - p[k]) <= rounding; })) {
                return true;
            }
        }
        return false;
    };
    const auto upright = [&](const std::array<Vec3, 3>& p) { // the normal around which its corners run
        return (p[1] - p[0]).cross(p[2] - p[0]).dot(n) < 0.0 ? Vec3(-n) : n;
    };
    return !has_outside(a, upright(a), b) && !has_outside(b, upright(b), a);
}

} // namespace difusa
