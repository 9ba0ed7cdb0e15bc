#include <difusa/import/texture_files.h>

namespace difusa {

std::shared_ptr<const Texture> TextureFiles::texture(const std::filesystem::path& file, Wrap wrap_u, Wrap wrap_v,
                                                     const TexturePlacement& placement) {
    const std::filesystem::path path = file.lexically_normal();
    std::vector<Entry>& made = textures_[path];
    for (const Entry& entry : made) {
        if (entry.wrap_u == wrap_u && entry.wrap_v == wrap_v && entry.placement == placement) {
            return entry.texture;
        }
    }
    std::shared_ptr<const Image>& image = images_[path];
    if (!image) {
        files_.push_back(file);
        image = std::make_shared<const Image>(read_image(file, PixelEncoding::srgb, notes_));
    }
    made.push_back({std::make_shared<const Texture>(image, wrap_u, wrap_v, placement), wrap_u, wrap_v, placement});
    return made.back().texture;
}

void TextureFiles::report(PolygonSoup& soup) const {
    soup.files.insert(soup.files.end(), files_.begin(), files_.end());
    soup.notes.insert(soup.notes.end(), notes_.begin(), notes_.end());
}

} // namespace difusa
