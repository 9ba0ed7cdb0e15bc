// Round values in a range, for the ticks of axes and scales.
#pragma once

#include <vector>

namespace difusa {

/// Multiples of `step` in [low, high], ascending; including ends that are multiples up to rounding.
std::vector<double> multiples_in(double low, double high, double step);

/// The largest power of ten not above a positive number.
double power_of_ten_below(double value);

} // namespace difusa
