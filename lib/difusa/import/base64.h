// Bytes in base64.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace difusa {

/// RFC 4648: `url` also accepts '-' and '_' for '+' and '/'.
enum class Base64 { standard, url };

/// Appends the decoded text to `bytes`, up to the first character that is not a base64 digit or until `bytes` has
/// `most` of them. Returns the number of characters consumed.
std::size_t decode_base64(std::string_view text, Base64 alphabet, std::string& bytes,
                          std::size_t most = static_cast<std::size_t>(-1));

} // namespace difusa
