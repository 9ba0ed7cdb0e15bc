// What light is to the eye.
#pragma once

#include <difusa/core/colour.h>

#include <numbers>

namespace difusa {

/// Luminous efficacy by which watts become lumens, and lumens in a file watts. A spectrum is not known: R, G and B in
/// W count as they do in the luminance of a linear sRGB colour (core/colour.h), so that white light of 1 W/m² in each
/// channel has 683 lux. This is also what glTF scenes are read with.
inline constexpr double lumens_per_watt = 683.0;

/// Illuminance in lux of irradiances in W/m²: #rows by 3 to #rows by 1.
inline Values illuminance_of(const Values& H) {
    return lumens_per_watt * (H * luminance_weights);
}

/// Luminance in cd/m² of diffuse surfaces with these radiosities in W/m²: #rows by 3 to #rows by 1.
inline Values luminance_of_diffuse(const Values& B) {
    return lumens_per_watt * std::numbers::inv_pi * (B * luminance_weights);
}

} // namespace difusa
