// Changes of the light and the colours of a scene, by the names of its materials and light groups.
#pragma once

#include <difusa/scene/scene.h>

#include <string>
#include <utility>
#include <vector>

namespace difusa {

/// Factors on the light of groups, by their names (scene/light_groups.h); 0 turns them off.
using LightFactors = std::vector<std::pair<std::string, double>>;

struct LightChange {
    LightFactors scale; ///< also on the light of materials whose emission is changed

    /// Emitted radiosity of materials, W/m², and their reflectance. Textures remain factors on both; a reflectance
    /// replaces colours at vertices.
    std::vector<std::pair<std::string, Rgb>> emission, reflectance;

    bool is_empty() const { return scale.empty() && emission.empty() && reflectance.empty(); }
};

/// Makes the changes. Throws UsageError, with the names there are, for an unknown material or group, for light that is
/// negative or not finite, and for a reflectance outside [0,1], that of the brightest place of a texture included.
void change_light(const LightChange& change, Scene& scene);

/// Scales groups of lights, one factor after the other. Throws likewise.
void scale_lights(const LightFactors& factors, Scene& scene);

} // namespace difusa
