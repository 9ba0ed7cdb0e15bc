#include <difusa/import/image_codecs.h>

#include <array>
#include <csetjmp>
#include <cstdio> // jpeglib.h needs it

#include <jpeglib.h>

#include <jerror.h>

namespace difusa {

namespace {

/// A decoder whose errors exit by longjmp: nothing with a destructor may be live where they occur.
struct JpegFile {
    jpeg_decompress_struct decoder{};
    jpeg_error_mgr errors{};
    jpeg_progress_mgr progress{};
    std::jmp_buf back{};
    std::array<char, JMSG_LENGTH_MAX> message{};

    JpegFile(const JpegFile&) = delete;
    JpegFile& operator=(const JpegFile&) = delete;
    JpegFile() {
        decoder.err = jpeg_std_error(&errors);
        errors.error_exit = on_error;
        errors.emit_message = on_message;
        errors.output_message = [](j_common_ptr) {};
        decoder.client_data = this;
    }
    ~JpegFile() { jpeg_destroy_decompress(&decoder); }

    bool read_header(const unsigned char* bytes, std::size_t size) {
        if (setjmp(back) != 0) { // NOLINT(cert-err52-cpp): the library's way to report errors
            return false;
        }
        jpeg_create_decompress(&decoder);
        decoder.client_data = this;
        progress.progress_monitor = on_progress;
        decoder.progress = &progress;
        jpeg_mem_src(&decoder, bytes, static_cast<unsigned long>(size));
        jpeg_read_header(&decoder, TRUE);
        return true;
    }
    bool start() {
        if (setjmp(back) != 0) { // NOLINT(cert-err52-cpp)
            return false;
        }
        decoder.dct_method = JDCT_ISLOW;
        jpeg_start_decompress(&decoder);
        return true;
    }
    bool read_row(JSAMPROW row) {
        if (setjmp(back) != 0) { // NOLINT(cert-err52-cpp)
            return false;
        }
        return jpeg_read_scanlines(&decoder, &row, 1) == 1;
    }
    bool finish() {
        if (setjmp(back) != 0) { // NOLINT(cert-err52-cpp)
            return false;
        }
        jpeg_finish_decompress(&decoder);
        return true;
    }

  private:
    [[noreturn]] static void on_error(j_common_ptr common) {
        auto* file = static_cast<JpegFile*>(common->client_data);
        common->err->format_message(common, file->message.data());
        std::longjmp(file->back, 1); // NOLINT(cert-err52-cpp)
    }
    /// The decoder's warnings also count as damage, except for bytes between segments, which some cameras leave.
    static void on_message(j_common_ptr common, int level) {
        if (level < 0 && common->err->msg_code != JWRN_EXTRANEOUS_DATA) {
            on_error(common);
        }
    }
    /// A small file can require thousands of passes over a large image.
    static void on_progress(j_common_ptr common) {
        constexpr int most_scans = 256;
        auto* file = static_cast<JpegFile*>(common->client_data);
        if (file->decoder.input_scan_number > most_scans) {
            std::snprintf(file->message.data(), file->message.size(), "more than %d passes", most_scans);
            std::longjmp(file->back, 1); // NOLINT(cert-err52-cpp)
        }
    }
};

} // namespace

Samples decode_jpeg(std::string_view content, const std::string& name) {
    JpegFile file;
    const auto refuse = [&] {
        refuse_image(name, std::string("damaged JPEG (") + file.message.data() + "): save the image again");
    };
    if (!file.read_header(reinterpret_cast<const unsigned char*>(content.data()), content.size())) {
        refuse();
    }
    jpeg_decompress_struct& decoder = file.decoder;
    if (decoder.num_components != 1 && decoder.num_components != 3) {
        refuse_image(name, "a JPEG of " + std::to_string(decoder.num_components) +
                               " colour components (CMYK); only RGB and grey are supported: save it as RGB");
    }
    decoder.out_color_space = decoder.num_components == 1 ? JCS_GRAYSCALE : JCS_RGB;
    check_image_size(name, decoder.image_width, decoder.image_height, 8, content.size());
    if (!file.start()) {
        refuse();
    }
    Samples samples;
    samples.width = decoder.output_width;
    samples.height = decoder.output_height;
    samples.channels = static_cast<std::size_t>(decoder.output_components);
    samples.values.reserve(samples.size());
    std::vector<JSAMPLE> row(samples.width * samples.channels);
    for (std::size_t r = 0; r < samples.height; ++r) {
        if (!file.read_row(row.data())) {
            refuse();
        }
        samples.values.insert(samples.values.end(), row.begin(), row.end());
    }
    if (!file.finish()) {
        refuse();
    }
    return samples;
}

} // namespace difusa
