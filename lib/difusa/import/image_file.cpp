#include <difusa/import/image_file.h>

#include <difusa/core/colour.h>
#include <difusa/core/error.h>
#include <difusa/core/memory.h>
#include <difusa/import/file_content.h>
#include <difusa/import/image_codecs.h>

#include <algorithm>
#include <cmath>

namespace difusa {

namespace {

bool begins(std::string_view content, std::string_view with) {
    return content.substr(0, with.size()) == with;
}

Samples decode(std::string_view content, const std::string& name) {
    using namespace std::string_view_literals;
    if (begins(content, "\x89PNG")) {
        return decode_png(content, name);
    }
    if (begins(content, "\xff\xd8\xff")) {
        return decode_jpeg(content, name);
    }
    if (begins(content, "#?")) {
        return decode_radiance(content, name);
    }
    if (begins(content, "BM")) {
        return decode_bmp(content, name);
    }
    if (begins(content, "II*\0"sv) || begins(content, "MM\0*"sv)) {
        return decode_tiff(content, name);
    }
    throw InputError(name + ": is not an image of a supported format (PNG, JPEG, TIFF, BMP, Radiance HDR): save it as "
                            "one of these");
}

} // namespace

void refuse_image(const std::string& name, const std::string& problem) {
    throw InputError(name + ": " + problem);
}

void check_image_size(const std::string& name, std::size_t width, std::size_t height, std::size_t bits_per_pixel,
                      std::size_t bytes) {
    constexpr double compression = 1032.0, largest_side = 1 << 20U;
    const double w = static_cast<double>(width), h = static_cast<double>(height);
    const std::string size = std::to_string(width) + " by " + std::to_string(height) + " pixels";
    if (width == 0 || height == 0) {
        refuse_image(name, "an image of " + size + ": save it again");
    }
    if (w > largest_side || h > largest_side ||
        w * h * static_cast<double>(bits_per_pixel) > 8.0 * compression * static_cast<double>(bytes)) {
        refuse_image(name, "its header promises " + size + ", which " + std::to_string(bytes) +
                               " bytes cannot hold: the file is damaged; save the image again");
    }
    constexpr double bytes_per_pixel = 4 * sizeof(std::uint16_t) + 3 * sizeof(float);
    if (w * h * bytes_per_pixel > 0x1p24) { // checking takes longer than decoding a small one
        require_memory(w * h * bytes_per_pixel, available_memory(), "the image " + name + " of " + size,
                       "make it smaller");
    }
}

Image decode_image(std::string_view content, const std::string& name, PixelEncoding encoding,
                   std::vector<std::string>& notes) {
    const Samples samples = decode(content, name);
    const std::size_t channels = samples.channels, colours = channels < 3 ? 1 : 3;
    const bool real = !samples.real.empty();
    DIFUSA_REQUIRE((real ? samples.real.size() : samples.values.size()) == samples.size(), name);

    std::vector<float> linear;
    if (!real) {
        linear.resize(std::size_t{samples.top} + 1);
        for (std::size_t v = 0; v < linear.size(); ++v) {
            const double part = static_cast<double>(v) / samples.top;
            linear[v] = static_cast<float>(encoding == PixelEncoding::srgb ? linear_of_srgb(part) : part);
        }
    }
    Image image;
    image.width = samples.width;
    image.height = samples.height;
    image.pixels.resize(samples.width * samples.height);
    std::size_t translucent = 0;
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
            const std::size_t at = i * channels + (colours == 3 ? c : 0);
            image.pixels[i][c] = real ? samples.real[at] : linear[samples.values[at]];
            if (!(image.pixels[i][c] >= 0.0F) || !std::isfinite(image.pixels[i][c])) {
                refuse_image(name, "the pixel in column " + std::to_string(i % image.width) + ", row " +
                                       std::to_string(i / image.width) +
                                       " (from the upper left, from 0) is negative or not finite: repair the image");
            }
        }
        if (channels > colours) {
            const std::size_t at = (i + 1) * channels - 1;
            translucent += real ? samples.real[at] < 1.0F : samples.values[at] < samples.top;
        }
    }
    if (translucent > 0) {
        notes.push_back(name + ": " + std::to_string(translucent) + " of " + std::to_string(image.pixels.size()) +
                        " pixels are not opaque; transparency is ignored, their colours are used");
    }
    return image;
}

Image read_image(const std::filesystem::path& file, PixelEncoding encoding, std::vector<std::string>& notes) {
    return decode_image(read_file(file), file.string(), encoding, notes);
}

} // namespace difusa
