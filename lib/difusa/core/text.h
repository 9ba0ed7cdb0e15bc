// Numbers in messages.
#pragma once

#include <cstdio>
#include <string>

namespace difusa {

/// Six significant digits, "0.25", "1e-09": enough to recognise a length, a ratio, a residual.
inline std::string text_of(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%g", value);
    return text;
}

} // namespace difusa
