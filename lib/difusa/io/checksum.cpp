#include <difusa/io/checksum.h>

#include <zlib.h>

namespace difusa {

std::uint32_t crc32_of(std::string_view bytes, std::uint32_t before) {
    if (bytes.empty()) { // whose address may be null: zlib would begin anew
        return before;
    }
    return static_cast<std::uint32_t>(crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

} // namespace difusa
