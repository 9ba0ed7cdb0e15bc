// Chapter 7 of the dissertation: the light of the ball over the disc along the ball's latitude and the disc's radius.
#pragma once

#include <difusa/bake.h>
#include <difusa/study/reference_case.h>

#include <string>
#include <vector>

namespace difusa {

/// Radiosity in W/m² of one body, for one kind of light.
struct RingCurve {
    std::string name;             ///< "disc, direct", ..., "ball, indirect"
    std::string place_title;      ///< axis title, with its unit
    std::vector<double> place;    ///< distance from the disc's centre, or latitude on the ball in rad
    std::vector<double> mean;     ///< over each ring
    std::vector<double> meridian; ///< at one azimuth
    std::vector<double> exact;
};

/// Direct, total and indirect light on `rings` rings of disc and ball, each sampled at `azimuths` azimuths. `reference`
/// is the case "ball-over-disc", and `result` a bake of it.
std::vector<RingCurve> ring_curves(const BakeResult& result, const ReferenceCase& reference, int rings, int azimuths,
                                   const Execution& execution);

/// The mean as a thick line, the meridian thin, the exact light dashed; an SVG document.
std::string chart_of(const RingCurve& curve, const std::string& title);

} // namespace difusa
