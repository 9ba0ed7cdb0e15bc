// The formats behind image_file.h, one function each. They call the formats' own libraries, because VTK's readers print
// the faults of a file to the terminal, and end the process at an in-memory PNG image with damaged data.
#pragma once

#include <difusa/scene/image.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace difusa {

/// Numbers as in the file, row by row from the top.
struct Samples {
    std::size_t width = 0, height = 0;
    std::size_t channels = 3;          ///< 1: grey, 2: grey and opacity, 3: R G B, 4: R G B and opacity
    std::uint16_t top = 255;           ///< the number that represents 1
    std::vector<std::uint16_t> values; ///< width times height times channels
    std::vector<float> real;           ///< instead of `values`: real numbers, linear

    std::size_t size() const { return width * height * channels; }
};

/// Throws InputError for an image without pixels, or with more than `bytes` bytes can hold (bits_per_pixel: before
/// compression; deflate, the best of those in use, leaves 1/1032); ResourceError if it does not fit into memory.
void check_image_size(const std::string& name, std::size_t width, std::size_t height, std::size_t bits_per_pixel,
                      std::size_t bytes);

/// Throws InputError "name: problem: remedy".
[[noreturn]] void refuse_image(const std::string& name, const std::string& problem);

/// Each throws InputError naming `name` for damaged or unsupported content.
Samples decode_png(std::string_view content, const std::string& name);
Samples decode_jpeg(std::string_view content, const std::string& name);
Samples decode_tiff(std::string_view content, const std::string& name);
Samples decode_bmp(std::string_view content, const std::string& name);
Samples decode_radiance(std::string_view content, const std::string& name);

} // namespace difusa
