// What was measured of the Cornell box's paints and lamp, and its reduction to three channels.
#pragma once

#include "surface.h"

namespace scenes {

/// A spectrum in linear sRGB: of each channel the mean from 400 to 700 nm, weighted with the channel's sensitivity,
/// which is the CIE 1931 matching functions through the sRGB matrix (IEC 61966-2-1). So a constant spectrum of 1, a
/// perfect white in light of equal energy, is (1, 1, 1), whatever its chromaticity. Rounded to four decimals.
struct CornellColours {
    Colour white, green, red; ///< reflectances
    Colour lamp;              ///< emission, as published: without a unit
};
CornellColours cornell_colours();

} // namespace scenes
