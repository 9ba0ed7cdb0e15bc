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

/// The text as XML 1.0 and JSON can hold it: '_' for each byte that is no part of UTF-8, and for each character that is
/// none of XML (XML 1.0, section 2.2: control characters but tab and line ends, surrogates, U+FFFE, U+FFFF).
std::string storable_text(std::string_view text);

} // namespace difusa
