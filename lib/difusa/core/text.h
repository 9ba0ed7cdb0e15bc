// Numbers in messages, names in files.
#pragma once

#include <difusa/core/types.h>

#include <array>
#include <charconv>
#include <cstddef>
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

/// "0.5,0.5,0.25".
inline std::string text_of(const Rgb& c) {
    return text_of(c[0]) + "," + text_of(c[1]) + "," + text_of(c[2]);
}

/// "1 face", "3 faces".
inline std::string counted(std::size_t count, std::string_view thing) {
    return std::to_string(count) + " " + std::string(thing) + (count == 1 ? "" : "s");
}

/// "(x, y, z)" with nine significant digits.
inline std::string coordinates(const Vec3& position) {
    std::array<char, 96> text{};
    std::snprintf(text.data(), text.size(), "(%.9g, %.9g, %.9g)", position.x(), position.y(), position.z());
    return text.data();
}

/// As many digits as it takes to read the same number back.
inline std::string exact_text(double value) {
    std::array<char, 32> text{};
    return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

/// A field of comma-separated values, in quotation marks; those inside are doubled (RFC 4180).
inline std::string csv_quoted(std::string_view text) {
    std::string result = "\"";
    for (const char c : text) {
        result += c == '"' ? "\"\"" : std::string(1, c);
    }
    return result + "\"";
}

/// The text in a form XML 1.0 and JSON can hold: '_' for each byte that is not valid UTF-8, and for each character not
/// allowed in XML (XML 1.0, section 2.2: control characters except tab and line ends, surrogates, U+FFFE, U+FFFF).
std::string storable_text(std::string_view text);

/// `storable_text` as the value of an XML attribute in quotation marks. Parsers turn line ends and tabs in attributes
/// into blanks unless they are written as character references.
std::string xml_attribute(std::string_view text);

} // namespace difusa
