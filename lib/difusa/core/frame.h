// An orthonormal frame around a direction.
#pragma once

#include <difusa/core/types.h>

#include <cmath>

namespace difusa {

/// Two unit vectors that make a right-handed orthonormal frame with the unit vector n (Duff et al., "Building an
/// Orthonormal Basis, Revisited", JCGT 6(1), 2017).
inline void tangents(const Vec3& n, Vec3& t, Vec3& b) {
    const double sign = std::copysign(1.0, n[2]);
    const double a = -1.0 / (sign + n[2]);
    const double c = n[0] * n[1] * a;
    t = Vec3(1.0 + sign * n[0] * n[0] * a, sign * c, -sign * n[0]);
    b = Vec3(c, sign + n[1] * n[1] * a, -n[1]);
}

/// The direction at this angle around n, of the share u of the disc below it: distributed as the cosine from n if u is
/// uniform in [0, 1) and the angle around the circle.
inline Vec3 cosine_direction(const Vec3& n, double u, double angle) {
    Vec3 t, b;
    tangents(n, t, b);
    return std::sqrt(u) * (std::cos(angle) * t + std::sin(angle) * b) + std::sqrt(1.0 - u) * n;
}

/// The rotation from that frame, in which n is z, to the world.
inline Eigen::Matrix3d frame_of(const Vec3& n) {
    Eigen::Matrix3d frame;
    Vec3 t, b;
    tangents(n, t, b);
    frame << t, b, n;
    return frame;
}

} // namespace difusa
