// False colours for numbers, and the scale that maps between them.
#pragma once

#include <difusa/core/types.h>

#include <vector>

namespace difusa {

/// From dark violet through blue and green to light yellow, for t in [0,1] (clamped); linear R, G, B.
///
/// A helix in Oklab (Ottosson 2020): lightness 0.25 to 0.92 and hue 310° to 105° vary evenly at a chroma of 0.098,
/// which is within sRGB for all of them. Equal steps of t are thus equal steps of perceived colour, and brightness
/// alone, as in a grey print, shows the order.
Rgb colour_map(double t);

/// The range of values the colours represent.
struct ColourScale {
    double low = 0.0, high = 1.0; ///< low < high; both positive if logarithmic
    bool logarithmic = false;

    /// 0 at `low`, 1 at `high`; clamped beyond.
    double position(double value) const;

    /// Round values from `low` to `high`, at least two of them except on a logarithmic scale of less than a decade:
    /// multiples of 1, 2 or 5 times a power of ten; on a logarithmic scale of a decade or more, powers of ten.
    std::vector<double> ticks() const;
};

/// A scale from the first to the last percentile of the values: a few bright ones leave colours for the others, and get
/// that of the end. If all are equal up to rounding it is widened around them. On a
/// logarithmic scale, values that are not positive or are below a millionth of the largest are ignored. Without any
/// value: 0 to 1, or 0.1 to 1.
ColourScale scale_for(const std::vector<float>& values, bool logarithmic);

} // namespace difusa
