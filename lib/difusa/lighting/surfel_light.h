// The light and reflectance of a scene on each surfel: everything the linear system needs to know of the lighting.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/discretisation/surfels.h>
#include <difusa/lighting/direct_light.h>

#include <cstdint>

namespace difusa {

/// Means over surfels; columns are the channels, or the channels of each set of lights in turn.
struct SurfelLight {
    Values reflectance;       ///< rho: #surfels by #channels
    Values emission;          ///< E, W/m²: #surfels by #sets #channels, from faces that are not area lights
    Values direct;            ///< H, W/m²: likewise, shadowed irradiance from suns, point lights and area lights
    Values all_emission;      ///< W/m²: #surfels by #channels, from all faces and sets
    Values from_outside;      ///< W/m²: #surfels by #channels, the part of `direct` from suns and point lights
    std::size_t segments = 0; ///< shadow rays cast

    /// rho ∘ H: likewise, direct light after one reflection.
    Values first_bounce() const;
};

/// Constants are averaged exactly; textures, patterns and corner colours over 16 points. Direct light is sampled at
/// four points of each surfel and, if these differ by more than a tenth of the brightest, as at a shadow edge, at 16
/// more.
SurfelLight light_on_surfels(const Scene& scene, const Surfels& surfels, const DirectLight& light, int channels,
                             std::uint64_t seed, const Execution& execution);

} // namespace difusa
