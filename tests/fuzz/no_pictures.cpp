// Pictures for the targets of readers: any file is one, of a few even pixels.
#include <difusa/core/error.h>
#include <difusa/import/image_file.h>

namespace difusa {

Image decode_image(std::string_view content, const std::string& name, PixelEncoding /*encoding*/,
                   std::vector<std::string>& notes) {
    if (content.empty()) {
        throw InputError(name + ": is empty");
    }
    notes.push_back(name + ": a picture");
    const float value = static_cast<float>(static_cast<unsigned char>(content[0])) / 255.0F;
    return {1, 2, {{value, value, value}, {1.0F, 0.0F, 0.5F}}};
}

Image read_image(const std::filesystem::path& file, PixelEncoding encoding, std::vector<std::string>& notes) {
    return decode_image(file.string(), file.string(), encoding, notes);
}

} // namespace difusa
