#include <difusa/core/digits.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace difusa {

std::string with_digits(double value, int digits) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.*e", digits - 1, value);
    const double rounded = std::strtod(text.data(), nullptr) + 0.0; // no negative zero
    if (std::abs(rounded) >= std::pow(10.0, digits) && std::abs(rounded) < 1e6) {
        std::snprintf(text.data(), text.size(), "%.0f", rounded);
    } else {
        std::snprintf(text.data(), text.size(), "%.*g", digits, rounded);
    }
    return text.data();
}

} // namespace difusa
