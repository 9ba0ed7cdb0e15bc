// Radiance images (.hdr, .pic): three mantissas and a common exponent, in run-length coded rows.
// Format: G. Ward, "Real Pixels", Graphics Gems II (1991); Radiance file formats, "picture".
#include <difusa/import/image_codecs.h>

#include <difusa/import/byte_scanner.h>
#include <difusa/import/text_scanner.h>

#include <cmath>

namespace difusa {

namespace {

using Rgbe = std::array<std::uint8_t, 4>;

/// The line up to the next LF, which is consumed too.
std::string_view take_line(std::string_view content, std::size_t& at) {
    const std::size_t end = std::min(content.find('\n', at), content.size());
    std::string_view line = content.substr(at, end - at);
    at = std::min(end + 1, content.size());
    return !line.empty() && line.back() == '\r' ? line.substr(0, line.size() - 1) : line;
}

/// A row in the 1991 form: runs for each component separately.
void take_components(ByteScanner& scanner, std::vector<Rgbe>& row, const Expected& expected) {
    for (std::size_t k = 0; k < 4; ++k) {
        for (std::size_t c = 0; c < row.size();) {
            std::size_t count = scanner.take<std::uint8_t>(expected);
            const bool run = count > 128;
            count -= run ? 128 : 0;
            if (count == 0 || count > row.size() - c) {
                scanner.fail("a run of " + std::to_string(count) + " pixels where " + std::to_string(row.size() - c) +
                             " are left in the row: the file is damaged; save the image again");
            }
            std::uint8_t value = run ? scanner.take<std::uint8_t>(expected) : std::uint8_t{0};
            for (; count > 0; --count, ++c) {
                value = run ? value : scanner.take<std::uint8_t>(expected);
                row[c][k] = value;
            }
        }
    }
}

/// A row of whole pixels; (1, 1, 1, n) repeats the previous one n times, n times 256 if it follows another such.
void take_pixels(ByteScanner& scanner, std::vector<Rgbe>& row, Rgbe first, const Expected& expected) {
    unsigned shift = 0;
    for (std::size_t c = 0; c < row.size();) {
        const Rgbe pixel = c == 0 ? first : scanner.take<Rgbe>(expected);
        if (pixel[0] != 1 || pixel[1] != 1 || pixel[2] != 1) {
            row[c++] = pixel;
            shift = 0;
            continue;
        }
        const std::size_t count = shift > 16 ? row.size() : std::size_t{pixel[3]} << shift;
        shift += 8;
        if (c == 0 || count > row.size() - c) {
            scanner.fail("a run of pixels does not fit into its row: the file is damaged; save the image again");
        }
        std::fill_n(row.begin() + static_cast<std::ptrdiff_t>(c), count, row[c - 1]);
        c += count;
    }
}

} // namespace

Samples decode_radiance(std::string_view content, const std::string& name) {
    std::size_t at = 0;
    take_line(content, at);
    double exposure = 1.0;
    for (std::string_view line = take_line(content, at); !line.empty(); line = take_line(content, at)) {
        if (line.substr(0, 7) == "FORMAT=" && line != "FORMAT=32-bit_rle_rgbe") {
            refuse_image(name, "a Radiance image of the format " + excerpt(line.substr(7)) +
                                   "; only 32-bit_rle_rgbe is supported: convert it");
        }
        if (line.substr(0, 9) == "EXPOSURE=") {
            std::string_view number = line.substr(9);
            number = number.substr(std::min(number.find_first_not_of(" \t"), number.size()));
            number = number.substr(0, number.find_last_not_of(" \t") + 1);
            double factor = 1.0; // pixels were multiplied by it
            if (!parse_real(number, factor) || !(factor > 0.0) || !std::isfinite(factor)) {
                refuse_image(name, "the exposure " + excerpt(number) + " is not a positive number: correct it");
            }
            exposure *= factor;
        }
    }
    const std::string_view size = take_line(content, at);
    TextScanner words(size.empty() ? std::string_view(" ") : size, name, {});
    std::string_view y, x;
    std::int64_t height = 0, width = 0;
    std::string_view height_word, width_word;
    if (!words.next(y, TextScanner::Reach::line) || !words.next(height_word, TextScanner::Reach::line) ||
        !words.next(x, TextScanner::Reach::line) || !words.next(width_word, TextScanner::Reach::line) || y != "-Y" ||
        x != "+X" || !parse_integer(height_word, height) || !parse_integer(width_word, width) || height < 0 ||
        width < 0) {
        refuse_image(
            name, "the size of a Radiance image is " + excerpt(size) +
                      "; only rows from the top, from left to right, are supported (-Y rows +X columns): convert it");
    }
    check_image_size(name, static_cast<std::size_t>(width), static_cast<std::size_t>(height), 32, content.size());

    Samples samples;
    samples.width = static_cast<std::size_t>(width);
    samples.height = static_cast<std::size_t>(height);
    samples.real.reserve(samples.size());
    ByteScanner scanner(content, name, std::endian::native, at); // bytes only
    std::vector<Rgbe> row(samples.width);
    for (std::size_t r = 0; r < samples.height; ++r) {
        const Expected expected{"row", r + 1, samples.height};
        const auto first = scanner.take<Rgbe>(expected);
        const std::size_t coded = first[2] * std::size_t{256} + first[3];
        if (first[0] == 2 && first[1] == 2 && coded == samples.width && coded >= 8 && coded < 32768) {
            take_components(scanner, row, expected);
        } else {
            take_pixels(scanner, row, first, expected);
        }
        for (const Rgbe& pixel : row) {
            // Mantissas are in 256ths; an exponent of 0 is black.
            const double scale = pixel[3] == 0 ? 0.0 : std::ldexp(1.0, pixel[3] - 136) / exposure;
            for (std::size_t k = 0; k < 3; ++k) {
                samples.real.push_back(static_cast<float>(pixel[k] * scale));
            }
        }
    }
    return samples;
}

} // namespace difusa
