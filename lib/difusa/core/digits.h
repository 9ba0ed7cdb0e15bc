// Numbers for people, rounded.
#pragma once

#include <string>

namespace difusa {

/// So many significant digits, from 1 to 6, without an exponent between 1e-4 and a million: "0.00034", "1200".
std::string with_digits(double value, int digits);

} // namespace difusa
