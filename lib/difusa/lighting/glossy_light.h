// The light of suns, point lights and area lights that glossy surfels reflect, by direction.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/discretisation/glossy_surfels.h>
#include <difusa/lighting/direct_light.h>
#include <difusa/mesh/lobe_harmonics.h>

#include <cstdint>
#include <functional>

namespace difusa {

/// Coefficients of pi times the radiance, in W/m², in spherical harmonics in the frame of the world: #parts
/// (GlossySurfels::parts) times #harmonics rows.
struct GlossyLight {
    Values all;               ///< #sets #channels columns
    Values from_outside;      ///< #channels columns: the share of suns and point lights
    std::size_t segments = 0; ///< shadow rays cast
};

/// Points of each surfel at which direct light is sampled.
constexpr std::size_t glossy_light_samples = 32;

/// `lobe(number)`: the harmonics of a lobe of the scene's mesh (GlossySurfaces::lobes).
GlossyLight glossy_light_on_surfels(const Scene& scene, const Surfels& surfels, const GlossySurfels& glossy,
                                    const SphericalHarmonics& harmonics,
                                    const std::function<const LobeHarmonics&(Index number)>& lobe,
                                    const DirectLight& light, int channels, std::uint64_t seed,
                                    const Execution& execution);

} // namespace difusa
