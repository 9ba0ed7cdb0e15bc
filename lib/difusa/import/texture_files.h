// Textures from image files, each of which is decoded once.
#pragma once

#include <difusa/import/image_file.h>
#include <difusa/repair/polygon_soup.h>
#include <difusa/scene/texture.h>

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace difusa {

class TextureFiles {
  public:
    using Wrap = Texture::Wrap;

    /// Colours from a file. Throws what `read_image` throws.
    std::shared_ptr<const Texture> texture(const std::filesystem::path& file, Wrap wrap_u = Wrap::repeat,
                                           Wrap wrap_v = Wrap::repeat,
                                           const TexturePlacement& placement = TexturePlacement::Identity());

    /// Adds the images' files, and what the user should know about them, to `soup`.
    void report(PolygonSoup& soup) const;

  private:
    struct Entry {
        std::shared_ptr<const Texture> texture;
        Wrap wrap_u, wrap_v;
        TexturePlacement placement;
    };
    std::map<std::filesystem::path, std::shared_ptr<const Image>> images_;
    std::map<std::filesystem::path, std::vector<Entry>> textures_;
    std::vector<std::filesystem::path> files_;
    std::vector<std::string> notes_;
};

} // namespace difusa
