// Images as files.
#pragma once

#include <difusa/scene/image.h>

#include <filesystem>
#include <string>

namespace difusa {

/// PNG with 8 bits per channel. Pixels are linear display values in [0,1] (clipped beyond), encoded with the sRGB
/// transfer function, as recorded in the file. Throws ResourceError if there is not enough memory.
std::string png_of(const Image& image);

/// Radiance RGBE ("HDR"), run-length encoded: linear pixels, accurate to 1/256 of their largest channel. Negative
/// values and NaN become 0.
std::string radiance_hdr_of(const Image& image);

/// True for a name that ends in .hdr. Throws UsageError for one that ends in neither .hdr nor .png.
bool is_radiance_hdr(const std::filesystem::path& file);

} // namespace difusa
