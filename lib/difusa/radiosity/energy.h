// Where the light of a bake goes: what comes in must be absorbed or leave.
#pragma once

#include <difusa/core/types.h>
#include <difusa/scene/scene.h>
#include <difusa/transport/transport.h>

#include <optional>
#include <vector>

namespace difusa {

/// Powers in W, per channel (1 or 3 entries).
struct EnergyBalance {
    Eigen::ArrayXd emitted;     ///< ∫ E dA: exact, emission patterns by a rule of second degree on each triangle
    Eigen::ArrayXd from_lights; ///< what arrives straight from suns and point lights
    Eigen::ArrayXd from_sky;    ///< what arrives straight from the sky
    Eigen::ArrayXd absorbed;    ///< ∫ (1-rho) H dA
    // Measured by rays, so absent where transport cast none (pairwise without a sky):
    std::optional<Eigen::ArrayXd> escaped; ///< leaves the scene between its surfaces
    std::optional<Eigen::ArrayXd> blocked; ///< ends on the backs of faces
    /// (in - absorbed - escaped - blocked) / in with in = emitted + from_lights + from_sky: what discretisation has
    /// lost (positive) or invented (negative).
    std::optional<Eigen::ArrayXd> imbalance;
};

/// `weight`: #points, quadrature weights: ∫ f dA ≈ sum_j weight_j f(x_j).
/// `rho`, `h`, `E`, `sun`: #points by #channels; h is all irradiance, `sun` that of suns and point lights (or empty:
/// none).
EnergyBalance energy_balance(const Scene& scene, const Transport& transport, const std::vector<double>& weight,
                             const Values& rho, const Values& h, const Values& E, const Values& sun = {});

} // namespace difusa
