// From light to what a screen can show.
#pragma once

#include <difusa/core/types.h>

#include <vector>

namespace difusa {

enum class ToneCurve {
    linear, ///< up to 1, cut above
    filmic  ///< dark parts keep their contrast, bright ones approach 1 slowly
};

/// A curve that resembles that of film: f(x) = x (2.51 x + 0.03) / (x (2.43 x + 0.59) + 0.14), cut at 1; increasing,
/// f(0) = 0. It is the fit of Narkowicz (2016) to the reference rendering transform of the Academy Color Encoding
/// System.
double filmic(double x);

/// Linear display values in [0,1]: the curve of light times `exposure`, each channel on its own.
Rgb tone_map(const Rgb& light, double exposure, ToneCurve curve);

/// The exposure under which 95 % of these luminances are at most 0.9; 1 if they are all dark, or none.
double exposure_for(std::vector<float> luminances);

} // namespace difusa
