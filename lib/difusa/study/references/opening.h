// Light that a surface element receives through an opening, by adaptive quadrature.
#pragma once

#include <difusa/core/types.h>

#include <functional>

namespace difusa {

/// Radiance that arrives from a unit direction, W/(m² sr).
using RadianceFrom = std::function<double(const Vec3& towards)>;

/// The parallelogram with the corner `a` and the edges `u` and `v`.
struct Opening {
    Vec3 a = Vec3::Zero(), u = Vec3::UnitX(), v = Vec3::UnitY();
};

/// The irradiance in W/m² of an element at x with the unit normal n from the radiance that comes through the opening,
///     E = ∫ L(w) max(0, n·w) |w·(u × v)| / r² ds dt,   w = (a + s u + t v - x) / r,   (s, t) in the unit square,
/// by Gauss-Legendre rules of 10 by 10 nodes on parts that are quartered until four quarters agree with the whole to
/// within 1e-8 of the first approximation of E (at most 12 times). For a radiance that is smooth in the opening; x must
/// not lie in it.
double irradiance_through(const Opening& opening, const Vec3& x, const Vec3& n, const RadianceFrom& radiance);

/// The irradiance of a vertical surface with the unit normal n from all that is above the horizon, z being up:
///     E = ∫∫ L cos²(e) cos(a) de da,   elevation e in [0, pi/2], azimuth a from n in [-pi/2, pi/2],
/// by a Gauss-Legendre rule of 96 nodes in each.
double vertical_irradiance(const Vec3& n, const RadianceFrom& radiance);

} // namespace difusa
