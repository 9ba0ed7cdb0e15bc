// Irradiance from a uniformly emitting polygon, in closed form.
#pragma once

#include <difusa/core/types.h>

#include <span>

namespace difusa {

/// The term of one edge in the formula below; corners relative to the element. A surface that is not plane, of which
/// all is above the horizon and seen from its front, has the sum over the edges of its outline, clockwise as seen from
/// the element: those between its faces cancel.
double lambert_edge(const Vec3& n, const Vec3& from, const Vec3& to);

/// The sum of the formula below over the edges of a convex polygon that lies above the horizon of a surface element
/// with unit normal n: corners relative to the element, clockwise seen from it. Not below 0.
double lambert_sum(const Vec3& n, std::span<const Vec3> polygon);

/// The unoccluded form factor from a surface element at x with unit normal n to the triangle abc:
///     F = (1/2pi) sum_i Gamma_i n·(p_i × p_{i+1}) / |p_i × p_{i+1}|
/// over the edges of the triangle clipped to the half space above the element's horizon, with p relative to x and
/// Gamma_i the angle between p_i and p_{i+1} (Lambert 1760; Baum, Rushmeier and Winget 1989). The irradiance is F times
/// the triangle's radiosity. 0 if x is not on the front side (counterclockwise) of the triangle. Exact to rounding.
double lambert_form_factor(const Vec3& x, const Vec3& n, const Vec3& a, const Vec3& b, const Vec3& c);

/// The same for a convex polygon of at most `most_lambert_corners`, counterclockwise as seen from the front.
double lambert_form_factor(const Vec3& x, const Vec3& n, std::span<const Vec3> polygon);
inline constexpr std::size_t most_lambert_corners = 32;

} // namespace difusa
