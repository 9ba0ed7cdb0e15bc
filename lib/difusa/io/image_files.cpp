#include <difusa/io/image_files.h>

#include <difusa/core/colour.h>
#include <difusa/core/error.h>

#include <png.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <vector>

namespace difusa {

namespace {

using Rgbe = std::array<std::uint8_t, 4>;

/// Three mantissas and their shared exponent (Ward, "Real pixels", 1991), rounded to nearest.
Rgbe rgbe(const std::array<float, 3>& pixel) {
    std::array<double, 3> c{};
    for (std::size_t k = 0; k < 3; ++k) {
        c[k] = pixel[k] > 0.0F ? static_cast<double>(pixel[k]) : 0.0; // 0 for NaN
    }
    const double largest = *std::max_element(c.begin(), c.end());
    int exponent = 0;
    std::frexp(std::min(largest, 1e38), &exponent);
    if (std::round(std::ldexp(std::min(largest, 1e38), 8 - exponent)) > 255.0) {
        ++exponent;
    }
    if (!(largest > 0.0) || exponent + 128 < 1) {
        return {0, 0, 0, 0};
    }
    Rgbe out{0, 0, 0, static_cast<std::uint8_t>(std::min(exponent + 128, 255))};
    for (std::size_t k = 0; k < 3; ++k) {
        out[k] = static_cast<std::uint8_t>(std::min(255.0, std::round(std::ldexp(c[k], 8 - exponent))));
    }
    return out;
}

/// One component of a row: runs of at least four equal bytes as (128 + length, byte), the rest as (length, bytes).
void encode_runs(const std::vector<std::uint8_t>& bytes, std::string& out) {
    const auto run_at = [&](std::size_t begin) {
        std::size_t end = begin + 1;
        while (end < bytes.size() && end - begin < 127 && bytes[end] == bytes[begin]) {
            ++end;
        }
        return end - begin;
    };
    std::size_t at = 0;
    while (at < bytes.size()) {
        std::size_t other = 0; // bytes until the next worthwhile run
        std::size_t run = run_at(at);
        while (run < 4 && at + other < bytes.size() && other < 128) {
            ++other;
            run = at + other < bytes.size() ? run_at(at + other) : 0;
        }
        if (other > 0) {
            out += static_cast<char>(other);
            out.append(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                       bytes.begin() + static_cast<std::ptrdiff_t>(at + other));
        } else {
            out += static_cast<char>(128 + run);
            out += static_cast<char>(bytes[at]);
            other = run;
        }
        at += other;
    }
}

} // namespace

std::string png_of(const Image& image) {
    std::vector<std::uint8_t> bytes;
    bytes.reserve(3 * image.pixels.size());
    for (const std::array<float, 3>& pixel : image.pixels) {
        for (const float c : pixel) {
            bytes.push_back(static_cast<std::uint8_t>(std::lround(255.0 * srgb(static_cast<double>(c)))));
        }
    }
    png_image header;
    std::memset(&header, 0, sizeof header);
    header.version = PNG_IMAGE_VERSION;
    header.width = static_cast<png_uint_32>(image.width);
    header.height = static_cast<png_uint_32>(image.height);
    header.format = PNG_FORMAT_RGB;
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(header);
    std::string file(size, '\0');
    if (png_image_write_to_memory(&header, file.data(), &size, 0, bytes.data(), 0, nullptr) == 0) {
        throw ResourceError(std::string("the picture cannot be encoded as PNG: ") + header.message);
    }
    file.resize(size);
    return file;
}

std::string radiance_hdr_of(const Image& image) {
    std::string file = "#?RADIANCE\n# linear R, G, B\nFORMAT=32-bit_rle_rgbe\n\n-Y " + std::to_string(image.height) +
                       " +X " + std::to_string(image.width) + "\n";
    const bool runs = image.width >= 8 && image.width <= 32767; // others are written uncompressed
    std::vector<Rgbe> row(image.width);
    std::vector<std::uint8_t> bytes(image.width);
    for (std::size_t y = 0; y < image.height; ++y) {
        for (std::size_t x = 0; x < image.width; ++x) {
            row[x] = rgbe(image.at(x, y));
        }
        if (!runs) {
            for (const Rgbe& pixel : row) {
                file.append(pixel.begin(), pixel.end());
            }
            continue;
        }
        file += {2, 2, static_cast<char>(image.width >> 8U), static_cast<char>(image.width & 255U)};
        for (std::size_t k = 0; k < 4; ++k) {
            std::transform(row.begin(), row.end(), bytes.begin(), [k](const Rgbe& pixel) { return pixel[k]; });
            encode_runs(bytes, file);
        }
    }
    return file;
}

bool is_radiance_hdr(const std::filesystem::path& file) {
    std::string extension = file.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (extension != ".png" && extension != ".hdr") {
        throw UsageError(file.string() + ": a picture's name ends in .png or, for linear radiances, in .hdr");
    }
    return extension == ".hdr";
}

} // namespace difusa
