// How means of the irradiance depend on emissions and reflectances: exact derivatives of the discretised equation, all
// of them from one solution of the transposed one.
//
// With the irradiances U = P Π h of the surfels, b = E + rho ∘ (H + U) and h = W [b; sky], the mean over a goal is
//     J = s.(P Π' h + H) + a.b + y.sky + H_sharp,
// where s are the goal's shares of the surfels if it is an area, a and y the shares of rays from its places that meet
// surfels and parts of the sky if it has places, and Π' the projection that fields are evaluated with. With
//     l = Π'ᵀ Pᵀ s + Πᵀ Pᵀ (rho ∘ a) + Tᵀ l   and   q = a + Dᵀ l,
// dJ/dE = q, dJ/drho = q ∘ (H + U), dJ/dH = s + rho ∘ q, for each surfel (the adjoint; compare goal_estimate.h).
#pragma once

#include <difusa/radiosity/goal_estimate.h>
#include <difusa/radiosity/system.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace difusa {

/// Of one goal. Everything is per channel: a channel depends on no other. A grey scene has three equal columns.
struct GoalGradient {
    std::string name;
    Rgb value = Rgb::Zero(); ///< J, W/m²: mean irradiance, without the limits that fields are kept to
    Values groups;           ///< #sets by 3, W/m²: by a factor on each set of lights; they sum to J
    Values emission;         ///< #materials by 3: by the emission of a material, as rays meet it
    Values reflectance;      ///< #materials by 3, W/m²: by the reflectance, a factor on its texture
    Values of_surfels;       ///< #surfels by #channels: q, by the emission of each
};

/// `solution`: with FirstBounce::operator_only, or without sharp lights; its sets are those of `groups`. `rays`: from
/// the places of a goal together, at least one from each. A material with colours at its vertices has the derivative by
/// a factor on them. Places are gathered at with fresh rays whose directions depend on `seed` alone, so that values
/// under other lights and colours differ by these alone.
///
/// Throws UsageError for a solution with live samples or with direct light in the basis, a thermal scene, glossy
/// materials, and a solver that has no transposed equation.
std::vector<GoalGradient> goal_gradients(const Solution& solution, std::span<const Goal> goals, std::size_t rays,
                                         std::uint64_t seed, const SolveOptions& solve, const Execution& execution);

} // namespace difusa
