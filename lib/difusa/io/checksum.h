// CRC-32, as in gzip and zip.
#pragma once

#include <cstdint>
#include <string_view>

namespace difusa {

/// Of `bytes`, or of them after others whose checksum is `before`.
std::uint32_t crc32_of(std::string_view bytes, std::uint32_t before = 0);

} // namespace difusa
