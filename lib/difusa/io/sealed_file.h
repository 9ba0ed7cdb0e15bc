// Files behind a seal: a block of text in front of the content says what it is, how long, and its checksum. Nothing
// reads a content that is damaged, cut short, or of another kind or version.
#pragma once

#include <difusa/io/whole_file.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace difusa {

/// What is behind a seal.
struct SealKind {
    std::string name;     ///< "difusa transport"
    unsigned version = 1; ///< of the format of the content; no other one is read
    std::string remedy;   ///< what to do about a file that is refused: "bake again with --save-transport"
};

/// Bytes in front of the content: lines of text, and zeros. A multiple of 512, as HDF5 wants of what precedes it.
inline constexpr std::size_t seal_size = 512;

/// The text: kind, version, length of the content in bytes, and its CRC-32 (that of zlib, PNG and ISO 3309).
std::string seal_of(const SealKind& kind, std::string_view content);

/// Writes seal and content.
void write_sealed(WholeFile& file, const SealKind& kind, std::string_view content);

/// Whether a file begins as those of this kind do; it may yet be damaged or of another version.
bool begins_as_sealed(const std::filesystem::path& file, const SealKind& kind);

/// The whole file, from the seal on. Throws InputError, with the reason and the remedy, for anything but a complete and
/// undamaged file of this kind and version, and what `read_file` throws.
std::string read_sealed(const std::filesystem::path& file, const SealKind& kind);

} // namespace difusa
