// Bytes in base64.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace difusa {

/// RFC 4648: `url` also takes '-' and '_', for '+' and '/'.
enum class Base64 { standard, url };

/// Appends what the text stands for to `bytes`, up to the first character that is no digit of base64 or until `bytes`
/// has `most` of them. Returns how many characters were taken.
std::size_t decode_base64(std::string_view text, Base64 alphabet, std::string& bytes,
                          std::size_t most = static_cast<std::size_t>(-1));

} // namespace difusa
