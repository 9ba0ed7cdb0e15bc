// From light to displayable values.
#pragma once

#include <difusa/core/types.h>

#include <vector>

namespace difusa {

enum class ToneCurve {
    linear, ///< up to 1, clipped above
    filmic  ///< dark parts keep their contrast, bright ones approach 1 gradually
};

/// A film-like curve: f(x) = x (2.51 x + 0.03) / (x (2.43 x + 0.59) + 0.14), clipped at 1; increasing, f(0) = 0. It is
/// Narkowicz's fit (2016) to the reference rendering transform of the Academy Color Encoding System.
double filmic(double x);

/// Linear display values in [0,1]: the curve applied to light times `exposure`, per channel.
Rgb tone_map(const Rgb& light, double exposure, ToneCurve curve);

/// The exposure at which 95 % of these luminances are at most 0.9; 1 if they are all dark, or there are none.
double exposure_for(std::vector<float> luminances);

} // namespace difusa
