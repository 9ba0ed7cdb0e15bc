// Measurements of the Cornell box's paints and area light, and their reduction to three channels.
#pragma once

#include "surface.h"

namespace scenes {

/// A spectrum in linear sRGB: for each channel the mean from 400 to 700 nm, weighted with the channel's sensitivity,
/// i.e. the CIE 1931 matching functions transformed by the sRGB matrix (IEC 61966-2-1). A constant spectrum of 1, a
/// perfect white in equal-energy light, is thus (1, 1, 1), whatever its chromaticity. Rounded to four decimals.
struct CornellColours {
    Colour white, green, red; ///< reflectances
    Colour lamp;              ///< emission, as published: without a unit
};
CornellColours cornell_colours();

} // namespace scenes
