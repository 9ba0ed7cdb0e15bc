#include <difusa/import/image_codecs.h>

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <memory>

#include <tiffio.h>

namespace difusa {

namespace {

/// A TIFF file in memory, and the first error found in it.
struct TiffSource {
    std::string_view content;
    std::size_t at = 0;
    std::string message;
};

tmsize_t read(thandle_t handle, void* out, tmsize_t count) {
    auto* source = static_cast<TiffSource*>(handle);
    const std::size_t left = source->content.size() - std::min(source->at, source->content.size());
    const std::size_t taken = std::min(left, static_cast<std::size_t>(std::max<tmsize_t>(count, 0)));
    if (taken > 0) {
        std::memcpy(out, source->content.data() + source->at, taken);
        source->at += taken;
    }
    return static_cast<tmsize_t>(taken);
}

tmsize_t write(thandle_t /*handle*/, void* /*in*/, tmsize_t /*count*/) {
    return -1;
}

toff_t seek(thandle_t handle, toff_t offset, int whence) {
    auto* source = static_cast<TiffSource*>(handle);
    const toff_t base = whence == SEEK_CUR ? source->at : whence == SEEK_END ? source->content.size() : 0;
    source->at = static_cast<std::size_t>(base + offset);
    return source->at;
}

int close(thandle_t /*handle*/) {
    return 0;
}

toff_t size(thandle_t handle) {
    return static_cast<TiffSource*>(handle)->content.size();
}

int on_error(TIFF* /*file*/, void* user, const char* /*module*/, const char* format, va_list arguments) {
    auto* source = static_cast<TiffSource*>(user);
    if (source->message.empty()) {
        char text[200];
        std::vsnprintf(text, sizeof text, format, arguments);
        source->message = text;
    }
    return 1;
}

int on_warning(TIFF* /*file*/, void* /*user*/, const char* /*module*/, const char* /*format*/, va_list /*arguments*/) {
    return 1;
}

} // namespace

Samples decode_tiff(std::string_view content, const std::string& name) {
    TiffSource source{content, 0, {}};
    const auto refuse = [&] { refuse_image(name, "damaged TIFF (" + source.message + "): save the image again"); };
    const std::unique_ptr<TIFFOpenOptions, void (*)(TIFFOpenOptions*)> options(TIFFOpenOptionsAlloc(),
                                                                               TIFFOpenOptionsFree);
    constexpr tmsize_t largest_piece = tmsize_t{1} << 30; // per allocation
    TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), largest_piece);
    TIFFOpenOptionsSetErrorHandlerExtR(options.get(), on_error, &source);
    TIFFOpenOptionsSetWarningHandlerExtR(options.get(), on_warning, &source);
    const std::unique_ptr<TIFF, void (*)(TIFF*)> file(
        TIFFClientOpenExt(name.c_str(), "rm", &source, read, write, seek, close, size, nullptr, nullptr, options.get()),
        TIFFClose);
    std::uint32_t width = 0, height = 0;
    if (!file || TIFFGetField(file.get(), TIFFTAG_IMAGEWIDTH, &width) == 0 ||
        TIFFGetField(file.get(), TIFFTAG_IMAGELENGTH, &height) == 0) {
        refuse();
    }
    std::uint16_t bits = 1, channels = 1, format = SAMPLEFORMAT_UINT, planes = PLANARCONFIG_CONTIG, meaning = 0,
                  corner = ORIENTATION_TOPLEFT;
    TIFFGetFieldDefaulted(file.get(), TIFFTAG_BITSPERSAMPLE, &bits);
    TIFFGetFieldDefaulted(file.get(), TIFFTAG_SAMPLESPERPIXEL, &channels);
    TIFFGetFieldDefaulted(file.get(), TIFFTAG_SAMPLEFORMAT, &format);
    TIFFGetFieldDefaulted(file.get(), TIFFTAG_PLANARCONFIG, &planes);
    TIFFGetFieldDefaulted(file.get(), TIFFTAG_ORIENTATION, &corner);
    TIFFGetField(file.get(), TIFFTAG_PHOTOMETRIC, &meaning);
    const bool whole = format == SAMPLEFORMAT_UINT && (bits == 8 || bits == 16);
    const bool real = format == SAMPLEFORMAT_IEEEFP && bits == 32;
    const bool grey = meaning == PHOTOMETRIC_MINISBLACK && channels <= 2;
    const bool rgb = meaning == PHOTOMETRIC_RGB && (channels == 3 || channels == 4);
    if (!(whole || real) || !(grey || rgb) || planes != PLANARCONFIG_CONTIG || corner != ORIENTATION_TOPLEFT ||
        TIFFIsTiled(file.get()) != 0) {
        refuse_image(name, "a TIFF of an unsupported kind; only grey or RGB in rows, of 8 or 16 bits or 32-bit real "
                           "numbers, is supported: save it like that, or as PNG");
    }
    check_image_size(name, width, height, std::size_t{bits} * channels, content.size());
    Samples samples;
    samples.width = width;
    samples.height = height;
    samples.channels = channels;
    samples.top = bits == 16 ? 65535 : 255;
    const std::size_t in_row = samples.width * samples.channels, row_bytes = in_row * bits / 8;
    if (TIFFScanlineSize64(file.get()) != row_bytes) {
        refuse();
    }
    std::vector<unsigned char> row(row_bytes);
    (real ? samples.real.resize(samples.size()) : samples.values.resize(samples.size()));
    for (std::uint32_t r = 0; r < height; ++r) {
        if (TIFFReadScanline(file.get(), row.data(), r, 0) < 0) {
            refuse();
        }
        if (real) {
            std::memcpy(samples.real.data() + r * in_row, row.data(), row_bytes);
        } else if (bits == 16) {
            std::memcpy(samples.values.data() + r * in_row, row.data(), row_bytes);
        } else {
            std::copy(row.begin(), row.end(), samples.values.begin() + static_cast<std::ptrdiff_t>(r * in_row));
        }
    }
    return samples;
}

} // namespace difusa
