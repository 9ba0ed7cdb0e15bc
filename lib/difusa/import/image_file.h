// Images from files: PNG, JPEG, TIFF, BMP, and Radiance HDR.
#pragma once

#include <difusa/scene/image.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace difusa {

/// The meaning of 8- or 16-bit whole numbers in a file. Real numbers (HDR, TIFF) are always linear.
enum class PixelEncoding {
    srgb,  ///< colours, by the transfer function of IEC 61966-2-1
    linear ///< other data, and measured colours
};

/// Decodes an image; the format is detected from its first bytes. Grey becomes R = G = B. Opacity is ignored; `notes`
/// says so if it is not full. Memory is bounded by what a file of this size can hold.
/// Throws InputError, naming `name` and the remedy, for damaged or truncated content or another format or colour space;
/// ResourceError if it does not fit into memory.
Image decode_image(std::string_view content, const std::string& name, PixelEncoding encoding,
                   std::vector<std::string>& notes);

/// The same from a file. Also throws what `read_file` throws.
Image read_image(const std::filesystem::path& file, PixelEncoding encoding, std::vector<std::string>& notes);

} // namespace difusa
