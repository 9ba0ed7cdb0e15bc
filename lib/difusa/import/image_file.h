// Pictures from files: PNG, JPEG, TIFF, BMP, and Radiance HDR.
#pragma once

#include <difusa/scene/image.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace difusa {

/// What whole numbers of 8 or 16 bits in a file mean. Real numbers (HDR, TIFF) are linear always.
enum class PixelEncoding {
    srgb,  ///< colours, by the transfer function of IEC 61966-2-1
    linear ///< other data, and measured colours
};

/// Decodes a picture; its format is told from its first bytes. Grey becomes R = G = B. Opacity is not read: `notes`
/// says so where it is not full. Memory is bounded by what a file of this size can hold.
/// Throws InputError, naming `name` and the remedy, for what is damaged, cut short, or in another format or colour
/// space; ResourceError if it does not fit into memory.
Image decode_image(std::string_view content, const std::string& name, PixelEncoding encoding,
                   std::vector<std::string>& notes);

/// The same from a file. Throws what `read_file` does, too.
Image read_image(const std::filesystem::path& file, PixelEncoding encoding, std::vector<std::string>& notes);

} // namespace difusa
