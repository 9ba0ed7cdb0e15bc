// Fuzz target: any bytes as a picture.
#include <difusa/core/error.h>
#include <difusa/import/image_file.h>

#include "fuzz_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    std::vector<std::string> notes;
    try {
        const difusa::Image image = difusa::decode_image({reinterpret_cast<const char*>(data), size}, "input",
                                                         difusa::PixelEncoding::srgb, notes);
        fuzz::hold(image.width > 0 && image.pixels.size() == image.width * image.height, "an image has pixels");
        for (const auto& pixel : image.pixels) {
            for (const float channel : pixel) {
                fuzz::hold(channel >= 0.0F && channel < 3e38F, "pixels are finite and not negative");
            }
        }
    } catch (const difusa::InputError& error) {
        fuzz::hold(std::string_view(error.what()).find("input") != std::string_view::npos, "messages name the file");
    } catch (const difusa::ResourceError&) { // a large picture of few bytes
    }
    return 0;
}
