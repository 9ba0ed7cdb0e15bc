#include <difusa/import/image_codecs.h>

#include <algorithm>
#include <array>
#include <bit>
#include <csetjmp>
#include <cstring>

#include <png.h>

namespace difusa {

namespace {

/// State for libpng's callbacks. Errors exit by longjmp, so nothing with a destructor may be live where they occur.
struct PngFile {
    png_structp png = nullptr;
    png_infop info = nullptr;
    const char* at = nullptr;
    std::size_t left = 0;
    std::array<char, 128> message{};

    PngFile(const PngFile&) = delete;
    PngFile& operator=(const PngFile&) = delete;
    explicit PngFile(std::string_view content) : at(content.data()), left(content.size()) {
        png = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, on_error, on_warning);
        info = png == nullptr ? nullptr : png_create_info_struct(png);
    }
    ~PngFile() { png_destroy_read_struct(&png, &info, nullptr); }

    /// Reads everything before the pixels, and requests grey or RGB samples of 8 or 16 bits. False after an error.
    bool read_header() {
        if (setjmp(png_jmpbuf(png)) != 0) { // NOLINT(cert-err52-cpp): the library's way to report errors
            return false;
        }
        png_set_read_fn(png, this, on_read);
        png_set_user_limits(png, 1U << 20U, 1U << 20U);
        png_read_info(png, info);
        png_set_expand(png); // palettes, fewer than 8 bits, transparent colours
        if constexpr (std::endian::native == std::endian::little) {
            png_set_swap(png);
        }
        png_set_interlace_handling(png);
        png_read_update_info(png, info);
        return true;
    }

    bool read_pixels(png_bytepp rows) {
        if (setjmp(png_jmpbuf(png)) != 0) { // NOLINT(cert-err52-cpp)
            return false;
        }
        png_read_image(png, rows);
        png_read_end(png, nullptr);
        return true;
    }

  private:
    static void on_read(png_structp png, png_bytep out, png_size_t count) {
        auto* file = static_cast<PngFile*>(png_get_io_ptr(png));
        if (count > file->left) {
            png_error(png, "the file ends too early");
        }
        std::memcpy(out, file->at, count);
        file->at += count;
        file->left -= count;
    }
    [[noreturn]] static void on_error(png_structp png, png_const_charp message) {
        auto* file = static_cast<PngFile*>(png_get_error_ptr(png));
        std::strncpy(file->message.data(), message, file->message.size() - 1);
        png_longjmp(png, 1);
    }
    static void on_warning(png_structp /*png*/, png_const_charp /*message*/) {}
};

} // namespace

Samples decode_png(std::string_view content, const std::string& name) {
    PngFile file(content);
    const auto refuse = [&] {
        refuse_image(name, std::string("damaged PNG (") + file.message.data() + "): save the image again");
    };
    if (file.info == nullptr || !file.read_header()) {
        refuse();
    }
    Samples samples;
    samples.width = png_get_image_width(file.png, file.info);
    samples.height = png_get_image_height(file.png, file.info);
    samples.channels = png_get_channels(file.png, file.info);
    const std::size_t bytes = png_get_bit_depth(file.png, file.info) == 16 ? 2 : 1;
    samples.top = bytes == 2 ? 65535 : 255;
    const std::size_t row_bytes = png_get_rowbytes(file.png, file.info);
    if (samples.channels < 1 || samples.channels > 4 || row_bytes != samples.width * samples.channels * bytes) {
        refuse_image(name, "a PNG of an unsupported kind: save it as RGB");
    }
    check_image_size(name, samples.width, samples.height, 1, content.size()); // pixels may have one bit each
    samples.values.resize(samples.size());
    // 8-bit rows go to the upper half of the space their samples will occupy.
    auto* const memory = reinterpret_cast<png_bytep>(samples.values.data());
    const std::size_t offset = (2 - bytes) * samples.size();
    std::vector<png_bytep> rows(samples.height);
    for (std::size_t r = 0; r < rows.size(); ++r) {
        rows[r] = memory + offset + r * row_bytes;
    }
    if (!file.read_pixels(rows.data())) {
        refuse();
    }
    if (bytes == 1) {
        const png_byte* const narrow = memory + offset;
        for (std::size_t i = 0; i < samples.size(); ++i) {
            samples.values[i] = narrow[i]; // writes only behind what is still to be read
        }
    }
    return samples;
}

} // namespace difusa
