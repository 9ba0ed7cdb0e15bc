// Pictures as files.
#pragma once

#include <difusa/scene/image.h>

#include <filesystem>
#include <string>

namespace difusa {

/// PNG of 8 bits a channel. Pixels are linear display values in [0,1] (cut beyond) and are encoded by the transfer
/// function of sRGB, which the file says. Throws ResourceError if there is no memory for it.
std::string png_of(const Image& image);

/// Radiance RGBE ("HDR"), run-length encoded: pixels as they are, to 1/256 of their largest channel. Values that
/// are negative or no numbers become 0.
std::string radiance_hdr_of(const Image& image);

/// True for a name that ends in .hdr. Throws UsageError for one that ends neither in that nor in .png.
bool is_radiance_hdr(const std::filesystem::path& file);

} // namespace difusa
