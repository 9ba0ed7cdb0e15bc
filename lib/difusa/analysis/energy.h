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
    Eigen::ArrayXd emitted;  ///< ∫ E dA, exact
    Eigen::ArrayXd from_sky; ///< what arrives straight from the sky
    Eigen::ArrayXd absorbed; ///< ∫ (1-rho) H dA
    // Measured by rays, so absent where transport cast none (pairwise without a sky):
    std::optional<Eigen::ArrayXd> escaped; ///< leaves the scene between its surfaces
    std::optional<Eigen::ArrayXd> blocked; ///< ends on the backs of faces
    /// (emitted + from_sky - absorbed - escaped - blocked) / (emitted + from_sky): what discretisation has lost
    /// (positive) or invented (negative).
    std::optional<Eigen::ArrayXd> imbalance;
};

/// `weight`: #S, quadrature weights of the sites: ∫ f dA ≈ sum_j weight_j f(x_j).
/// `rho`, `h`, `E`: #S by #channels at the sites; E is the element-averaged emission.
EnergyBalance energy_balance(const Scene& scene, const Transport& transport, const std::vector<double>& weight,
                             const Values& rho, const Values& h, const Values& E);

} // namespace difusa
