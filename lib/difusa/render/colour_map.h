// Colours for numbers, and the scale that says which number a colour stands for.
#pragma once

#include <difusa/core/types.h>

#include <vector>

namespace difusa {

/// From dark violet through blue, green to light yellow, for t in [0,1] (clamped); linear R, G, B.
///
/// A helix in Oklab (Ottosson 2020): lightness 0.25 to 0.92 and hue 310° to 105° grow evenly at a chroma of 0.098,
/// which all of them can have in sRGB. So equal steps of t are equal steps of perceived colour, and brightness alone,
/// as in a grey print, tells the order.
Rgb colour_map(double t);

/// Which values the colours stand for.
struct ColourScale {
    double low = 0.0, high = 1.0; ///< low < high; both positive if logarithmic
    bool logarithmic = false;

    /// 0 at `low`, 1 at `high`; beyond them cut.
    double position(double value) const;

    /// Round values from `low` to `high`, at least two of them but on a logarithmic scale of less than a decade:
    /// multiples of 1, 2 or 5 times a power of ten; on a logarithmic scale of a decade or more, powers of ten.
    std::vector<double> ticks() const;
};

/// A scale from the least to the largest value. Where all are equal up to rounding it is widened around them. On a
/// logarithmic scale values that are not positive do not count, nor does what is below a millionth of the largest.
/// Without any value: 0 to 1, or 0.1 to 1.
ColourScale scale_for(const std::vector<float>& values, bool logarithmic);

} // namespace difusa
