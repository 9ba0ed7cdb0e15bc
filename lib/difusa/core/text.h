// Numbers in messages, names in files.
#pragma once

#include <cstdio>
#include <string>
#include <string_view>

namespace difusa {

/// Six significant digits, "0.25", "1e-09": enough to recognise a length, a ratio, a residual.
inline std::string text_of(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%g", value);
    return text;
}

/// The text in a form XML 1.0 and JSON can hold: '_' for each byte that is not valid UTF-8, and for each character not
/// allowed in XML (XML 1.0, section 2.2: control characters except tab and line ends, surrogates, U+FFFE, U+FFFF).
std::string storable_text(std::string_view text);

} // namespace difusa
