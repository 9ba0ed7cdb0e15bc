// Materials of glTF files, with their textures.
#pragma once

#include <difusa/import/gltf_input.h>
#include <difusa/import/image_file.h>

#include <array>
#include <map>
#include <memory>
#include <tuple>
#include <utility>

namespace difusa {

class GltfMaterials {
  public:
    struct Surface {
        Material material;
        std::size_t texture_set = 0;
    };

    /// `input` must outlive the object.
    explicit GltfMaterials(GltfInput& input) : input_(input) {}

    /// Material `index` of the file, read once.
    const Surface& surface(const JsonValue& index);

    /// The soup's number for a material of the file (or for none), with or without vertex colours, whose mean is a
    /// factor on what a metal reflects in mirrors and glossily.
    Index material(const JsonValue* index, bool painted, const Rgb& mean_colour);

  private:
    /// An image on a material, and which of a vertex' coordinates are used for it.
    struct Map {
        std::shared_ptr<const Texture> texture;
        std::size_t set = 0;
    };
    /// Decoded once. Null, with a note, for an image that is missing or not of a kind built into glTF.
    std::shared_ptr<const Image> image(const JsonValue& texture, PixelEncoding encoding);
    Texture::Wrap wrap(const JsonValue& sampler, const char* name) const;
    /// KHR_texture_transform, with v pointing up as in textures here: u' = offset + R scale u, where R rotates
    /// counterclockwise on the image.
    TexturePlacement placement(const JsonValue& transform) const;
    /// A "textureInfo" of the file.
    Map map(const JsonValue& from);
    /// The image of a "textureInfo"; null as in image().
    std::shared_ptr<const Image> image_of(const JsonValue& from, PixelEncoding encoding);
    /// The mean of a channel of a linear texture, at most 1; 1 if it cannot be read.
    double mean_of(const JsonValue& texture, std::size_t channel);
    /// Metals have no diffuse part. For a texture its mean is used.
    double metallic(const JsonValue& pbr, const std::string& name);
    /// The roughness, at least LobeShape::least_roughness. For a texture its mean is used.
    double roughness(const JsonValue& pbr, const std::string& name);
    /// The specular part of KHR_materials_pbrSpecularGlossiness, which is not diffuse: the largest channel of the
    /// specular colour. For a texture its mean is used.
    double specular(const JsonValue& gloss, const std::string& name);
    void note_metal(double share, const std::string& name);
    /// True if a surface of this roughness reflects like a mirror: roughness 0, without a texture.
    bool is_polished(const JsonValue& pbr) const;
    /// Four numbers, of which the last, opacity, is ignored.
    Rgb colour(const JsonValue& object, const char* member) const;
    Surface surface(const JsonValue& from, std::size_t index);

    GltfInput& input_;
    std::map<std::pair<std::size_t, PixelEncoding>, std::shared_ptr<const Image>> images_;
    std::map<std::size_t, std::vector<std::pair<TexturePlacement, std::shared_ptr<const Texture>>>> textures_;
    std::map<std::size_t, Surface> surfaces_;
    using Variant = std::tuple<std::size_t, bool, std::array<double, 3>>; ///< number in the file, painted, mean colour
    std::map<Variant, Index> numbers_;                                    ///< of materials in the soup
};

} // namespace difusa
