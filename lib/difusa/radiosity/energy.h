// The energy balance of a bake: light that enters must be absorbed or leave.
#pragma once

#include <difusa/core/types.h>
#include <difusa/discretisation/discretisation.h>
#include <difusa/lighting/surfel_light.h>
#include <difusa/rays/tracer.h>
#include <difusa/transport/light_transport.h>

#include <cstdint>

namespace difusa {

/// Powers in W, per channel (1 or 3 entries).
struct EnergyBalance {
    Eigen::ArrayXd emitted; ///< ∫ E dA: exact; emission patterns by a second-degree rule on each triangle, textures
                            ///< by one on parts of an eighth of a pixel, or over about a million points
    Eigen::ArrayXd from_lights; ///< incident directly from suns and point lights
    Eigen::ArrayXd from_sky;    ///< incident directly from the sky; both without what mirrors and glossy surfaces pass
                                ///< on, which counts where it ends
    Eigen::ArrayXd absorbed;    ///< ∫ (1-rho-mirror-gloss) H dA
    Eigen::ArrayXd escaped;     ///< leaves the scene
    Eigen::ArrayXd blocked;     ///< lost on the backs of faces
    Eigen::ArrayXd cut_off;     ///< lost between mirrors, after Mirrors::most reflections in a row
    /// (in - absorbed - escaped - blocked - cut_off) / in with in = emitted + from_lights + from_sky: the light lost
    /// (positive) or created (negative) by the discretisation. Divided by the sum of magnitudes in a thermal scene, of
    /// which all these are differences to the reference temperature.
    Eigen::ArrayXd imbalance;
};

/// Integrals over the surface are sums over the surfels. `light`: of all sets; `irradiance`: total, means over the
/// surfels, #surfels by #channels; `from_sky`: at the points, directly from the sky, #points by #channels;
/// `from_lights`: likewise, what glossy surfaces pass on of the light of suns and point lights, or no rows. Of emitting
/// surfels that no element reaches, most often since no light does, 64 rays each tell what escapes and what is blocked;
/// mirrors end them.
EnergyBalance energy_balance(const Scene& scene, const Tracer& tracer, std::uint64_t seed,
                             const Discretisation& discretisation, const LightTransport& transport,
                             const SurfelLight& light, const Values& irradiance, const Values& from_sky,
                             const Values& from_lights, const Execution& execution);

} // namespace difusa
