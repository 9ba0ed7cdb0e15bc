#include <difusa/core/text.h>

#include <cstddef>

namespace difusa {

namespace {

/// Number of bytes of the XML character at `i`, in shortest-form UTF-8; 0: there is none.
std::size_t character_length(std::string_view text, std::size_t i) {
    const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
    const unsigned lead = byte(i);
    if (lead < 0x80) {
        return lead >= 0x20 || lead == '\t' || lead == '\n' || lead == '\r' ? 1 : 0;
    }
    const std::size_t length = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
    if (lead < 0xc2 || lead > 0xf4 || text.size() - i < length) {
        return 0;
    }
    unsigned long code = lead & (0xffU >> (length + 1));
    for (std::size_t k = i + 1; k < i + length; ++k) {
        if ((byte(k) & 0xc0U) != 0x80U) {
            return 0;
        }
        code = code << 6U | (byte(k) & 0x3fU);
    }
    const bool shortest = length == 2 || code >= (length == 3 ? 0x800UL : 0x10000UL);
    const bool excluded = (code >= 0xd800 && code < 0xe000) || code == 0xfffe || code == 0xffff || code > 0x10ffff;
    return shortest && !excluded ? length : 0;
}

} // namespace

std::string storable_text(std::string_view text) {
    std::string result;
    for (std::size_t i = 0; i < text.size();) {
        const std::size_t length = character_length(text, i);
        result += length == 0 ? "_" : text.substr(i, length);
        i += length == 0 ? 1 : length;
    }
    return result;
}

std::string xml_attribute(std::string_view text) {
    std::string value;
    for (const char c : storable_text(text)) {
        switch (c) {
        case '&':
            value += "&amp;";
            break;
        case '<':
            value += "&lt;";
            break;
        case '>':
            value += "&gt;";
            break;
        case '"':
            value += "&quot;";
            break;
        case '\t':
        case '\n':
        case '\r':
            value += "&#" + std::to_string(static_cast<int>(c)) + ";";
            break;
        default:
            value += c;
        }
    }
    return value;
}

} // namespace difusa
