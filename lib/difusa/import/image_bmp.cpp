// Uncompressed Windows bitmaps.
#include <difusa/import/byte_scanner.h>
#include <difusa/import/image_codecs.h>

namespace difusa {

Samples decode_bmp(std::string_view content, const std::string& name) {
    ByteScanner header(content, name, std::endian::little, 10);
    const Expected expected{"the header of a BMP image"};
    const auto data_at = header.take<std::uint32_t>(expected);
    const auto header_size = header.take<std::uint32_t>(expected);
    if (header_size < 40) {
        refuse_image(name, "a BMP of an unsupported kind: save it as PNG");
    }
    const auto width = header.take<std::int32_t>(expected);
    const auto rows = header.take<std::int32_t>(expected); // negative: the first row is the top one
    header.take<std::uint16_t>(expected);
    const auto bits = header.take<std::uint16_t>(expected);
    const auto compression = header.take<std::uint32_t>(expected);
    if ((bits != 8 && bits != 24 && bits != 32) || compression != 0) {
        refuse_image(name,
                     "a BMP with " + std::to_string(bits) + " bits per pixel and compression " +
                         std::to_string(compression) +
                         "; only 8, 24 and 32 bits without compression are supported: save it like that, or as PNG");
    }
    header.skip(12, expected);
    const auto named = header.take<std::uint32_t>(expected);
    const std::size_t height = static_cast<std::size_t>(rows < 0 ? -std::int64_t{rows} : std::int64_t{rows});
    check_image_size(name, static_cast<std::size_t>(std::max(width, 0)), height, bits, content.size());

    std::vector<std::array<std::uint8_t, 4>> palette; // B G R and padding
    if (bits == 8) {
        ByteScanner colours(content, name, std::endian::native,
                            std::min<std::size_t>(14 + header_size, content.size()));
        palette.resize(named == 0 || named > 256 ? 256 : named);
        for (auto& colour : palette) {
            colour = colours.take<std::array<std::uint8_t, 4>>({"the palette of a BMP image"});
        }
    }
    Samples samples;
    samples.width = static_cast<std::size_t>(width);
    samples.height = height;
    samples.values.resize(samples.size());
    const std::size_t pixel_bytes = bits / 8U, padding = (4 - samples.width * pixel_bytes % 4) % 4;
    ByteScanner pixels(content, name, std::endian::little, std::min<std::size_t>(data_at, content.size()));
    for (std::size_t r = 0; r < height; ++r) {
        std::uint16_t* out = samples.values.data() + (rows < 0 ? r : height - 1 - r) * samples.width * 3;
        const Expected pixel{"row", r + 1, height};
        for (std::size_t c = 0; c < samples.width; ++c, out += 3) {
            if (bits == 8) {
                const auto number = pixels.take<std::uint8_t>(pixel);
                if (number >= palette.size()) {
                    pixels.fail("a pixel has the colour " + std::to_string(number) + " of " +
                                std::to_string(palette.size()) + ": the file is damaged; save the image again");
                }
                for (std::size_t k = 0; k < 3; ++k) {
                    out[k] = palette[number][2 - k];
                }
                continue;
            }
            for (std::size_t k = 0; k < 3; ++k) {
                out[2 - k] = pixels.take<std::uint8_t>(pixel);
            }
            pixels.skip(pixel_bytes - 3, pixel);
        }
        if (r + 1 < height) {
            pixels.skip(padding, pixel);
        }
    }
    return samples;
}

} // namespace difusa
