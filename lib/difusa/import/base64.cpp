#include <difusa/import/base64.h>

#include <cstdint>

namespace difusa {

namespace {

/// The value of a digit; -1 for other characters.
int base64_digit(char c, Base64 alphabet) {
    if (c >= 'A' && c <= 'Z') {
        return c - 'A';
    }
    if (c >= 'a' && c <= 'z') {
        return c - 'a' + 26;
    }
    if (c >= '0' && c <= '9') {
        return c - '0' + 52;
    }
    const bool url = alphabet == Base64::url;
    return c == '+' || (url && c == '-') ? 62 : c == '/' || (url && c == '_') ? 63 : -1;
}

} // namespace

std::size_t decode_base64(std::string_view text, Base64 alphabet, std::string& bytes, std::size_t most) {
    std::uint32_t bits = 0;
    unsigned held = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const int digit = base64_digit(text[i], alphabet);
        if (digit < 0 || bytes.size() >= most) {
            return i;
        }
        bits = bits << 6U | static_cast<std::uint32_t>(digit);
        held += 6;
        if (held >= 8) {
            held -= 8;
            bytes += static_cast<char>(bits >> held & 255U);
        }
    }
    return text.size();
}

} // namespace difusa
