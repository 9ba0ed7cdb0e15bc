// How accurate is a bake? Its own equation tells: the residual
//     r(x) = E(x) + rho(x) (H_direct(x) + (K B~)(x)) - B~(x)
// of the computed radiosity B~ is measured at random surface points with fresh rays. With rho_max < 1 the largest
// reflectance,
//     ‖B - B~‖ <= ‖r‖ / (1 - rho_max)
// for the root mean square over the area as well as for the maximum, because the transport operator K has norm 1 at
// most in both (its kernel is symmetric and its row sums are at most 1).
#pragma once

#include <difusa/discretisation/basis.h>
#include <difusa/radiosity/field.h>

#include <vector>

namespace difusa {

struct ErrorEstimate {
    std::size_t points = 0, rays = 0, segments = 0; ///< surface points; rays and segments cast in all
    double reflected = 0.0; ///< rms of B~ - E over the area, all channels together, W/m²: what errors are told relative
                            ///< to, since the brightness of a lamp says nothing about the light on the walls

    // Of the residual over the area, all channels together, W/m². Two independent estimates of r(x) are multiplied, so
    // that the noise of the rays does not count as error; `low` and `high` are the ends of the 95 % confidence
    // interval.
    double rms = 0.0, low = 0.0, high = 0.0;
    double largest = 0.0; ///< seen at the points, of the mean of both estimates

    double largest_reflectance = 0.0; ///< rho_max
    double factor = 0.0;              ///< rho_max / (1 - rho_max) if the output was gathered, else 1 / (1 - rho_max)
    double noise = 0.0;               ///< rms over the vertices of a gathered output of its noise, W/m²; else 0

    // Bounds of the error of the output, W/m²; infinite if some surface absorbs nothing.
    double bound_rms = 0.0;     ///< factor · high + noise
    double bound_largest = 0.0; ///< factor · largest + noise: holds as far as the points have seen the largest residual

    // At the points, to be spread over the surface:
    std::vector<SurfacePoint> place;
    std::vector<double> squared; ///< unbiased estimates of |r|², may be negative
};

/// Measures at `points` points, spread evenly, with twice `rays` rays each.
ErrorEstimate estimate_error(const Field& field, std::size_t points, std::size_t rays, std::uint64_t seed,
                             const Execution& execution);

/// The root of the local mean of `squared`, W/m², at each x: the mean over the points around it, weighted by how much
/// they share basis elements with it; the mean of all where there is none.
Values spread_residual(const ErrorEstimate& estimate, const Basis& basis, std::span<const SurfacePoint> x,
                       const Execution& execution);

/// The largest reflectance of the scene, over faces and channels.
double largest_reflectance(const Scene& scene, int channels);

} // namespace difusa
