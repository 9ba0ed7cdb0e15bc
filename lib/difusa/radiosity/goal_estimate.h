// Goal-oriented error estimation: the mean irradiance over a part of the surface, corrected, with an interval.
//
// Let h~ be the light that the coefficients represent, and s(x) = h(x; h~) - h~(x) its residual, with h(.; h~) gathered
// from h~. Then the true light is h~ + e with e = s + K rho e, where K carries the radiosity of the surface to
// irradiance. K is symmetric: the mean of e over a goal, whose normalised indicator is d, is
//     <d, e> = <d, s> + <rho z, s>,   z = K d + K rho z,
// where z is the irradiance that the goal would cause as a lamp of radiosity d (the dual-weighted residual: Becker and
// Rannacher 2001). Both products are measured with fresh rays. z is found twice: with the basis, to choose where s is
// measured, and by rays between surfels (surfel_transport.h), to weigh it. The basis fails for z where it fails for h~,
// as in a narrow cove full of light: with z from the basis the correction would lack the product of these errors. From
// places, K rho s and K rho K rho s are measured along paths, since K d varies within surfels near a place; z is then
// what follows.
#pragma once

#include <difusa/radiosity/system.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace difusa {

/// Where a mean is wanted: over the area of triangles or, without any, over places of equal weight.
struct Goal {
    std::string name;
    std::vector<Index> triangles; ///< of the scene's mesh, each at most once
    std::vector<SurfacePoint> places;
};

/// The share of a goal's area that is on each surfel, #surfels; they sum to 1. `area`: of the goal.
std::vector<double> goal_shares(const Goal& goal, double area, const Mesh& mesh, const Surfels& surfels);

/// Irradiance, direct and indirect, W/m²; a grey scene has three equal channels.
struct GoalEstimate {
    std::string name;
    double area = 0.0;                  ///< of the goal; 0 for places
    std::size_t places = 0;             ///< of the goal; 0 for an area
    Rgb field = Rgb::Zero();            ///< mean of the light as evaluated from the basis
    Rgb mean = Rgb::Zero();             ///< the same, corrected
    Rgb low = Rgb::Zero(), high = low;  ///< ends of the 95 % confidence interval of the corrected mean
    std::size_t rays = 0, segments = 0; ///< cast
};

/// `samples`: places at which the residual is gathered for each goal, half of them on the goal, half where its error
/// comes from, and of places as many again on paths from them; `rays` from each. They are those of 16 repetitions, each
/// of which takes all places of a goal that has places, as often as its samples suffice for, but at least once: many
/// places take more than `samples`. The rays between surfels serve all goals and are counted with the first; where
/// surfaces are glossy, z is that of the basis. Throws UsageError for a goal without triangles and places.
std::vector<GoalEstimate> estimate_goals(const Solution& solution, std::span<const Goal> goals, std::size_t samples,
                                         std::size_t rays, std::uint64_t seed, const Execution& execution);

} // namespace difusa
