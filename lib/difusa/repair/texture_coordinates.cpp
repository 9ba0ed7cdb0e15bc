#include <difusa/repair/texture_coordinates.h>

#include <difusa/repair/findings.h>

#include <algorithm>
#include <array>
#include <memory>

namespace difusa {

namespace {

/// The material with its textures' mean colours. The reflectance of one that takes it from vertex colours stays a
/// factor on these: a texture of one pixel.
Material without_textures(Material material) {
    if (material.reflectance_texture && material.vertex_colours) {
        const Rgb mean = material.reflectance_texture->mean();
        const std::array<float, 3> pixel{static_cast<float>(mean[0]), static_cast<float>(mean[1]),
                                         static_cast<float>(mean[2])};
        material.reflectance_texture = std::make_shared<const Texture>(Image{1, 1, {pixel}});
    } else if (material.reflectance_texture) {
        material.reflectance *= material.reflectance_texture->mean();
        material.reflectance_texture = nullptr;
    }
    if (material.emission_texture) {
        material.emission *= material.emission_texture->mean();
        material.emission_texture = nullptr;
    }
    return material;
}

} // namespace

void settle_textures(PolygonSoup& soup) {
    const std::size_t materials = soup.materials.size();
    if (std::none_of(soup.materials.begin(), soup.materials.end(), is_textured)) {
        return;
    }
    std::vector<Index> plain(materials, none); // the replacement for each material
    std::size_t faces = 0, first = 0, far = 0, first_far = 0;
    for (std::size_t f = 0; f < soup.face_count(); ++f) {
        const Index m = soup.face_material[f];
        if (m == none || !is_textured(soup.materials[m])) {
            continue;
        }
        const auto begin = static_cast<std::ptrdiff_t>(soup.first_corner[f]);
        const auto end = static_cast<std::ptrdiff_t>(soup.first_corner[f + 1]);
        const bool has_coordinates =
            !soup.corner_texture.empty() &&
            std::all_of(soup.corner_texture.begin() + begin, soup.corner_texture.begin() + end, is_placed);
        if (has_coordinates &&
            std::all_of(soup.corner_texture.begin() + begin, soup.corner_texture.begin() + end,
                        [&](const TextureCoordinates& each) { return is_placed_on(soup.materials[m], each); })) {
            continue;
        }
        if (plain[m] == none) {
            plain[m] = static_cast<Index>(soup.materials.size());
            soup.materials.push_back(without_textures(soup.materials[m]));
        }
        soup.face_material[f] = plain[m];
        if (is_textured(soup.materials[plain[m]])) { // anywhere on its one pixel
            soup.corner_texture.resize(soup.corners.size(), unplaced);
            std::fill(soup.corner_texture.begin() + begin, soup.corner_texture.begin() + end,
                      TextureCoordinates(TextureCoordinates::Zero()));
        }
        if (has_coordinates) {
            first_far = far++ == 0 ? f : first_far;
        } else {
            first = faces++ == 0 ? f : first;
        }
    }
    if (faces > 0) {
        soup.notes.push_back(
            "faces without texture coordinates whose material has a texture: " + std::to_string(faces) +
            " (first: " + face_name(soup, first) + "); the texture's mean colour is used instead");
    }
    if (far > 0) {
        soup.notes.push_back(
            "faces of a material that moves or scales its texture too far to resolve pixels: " + std::to_string(far) +
            " (first: " + face_name(soup, first_far) + ", of \"" + soup.materials[soup.face_material[first_far]].name +
            "\"); the texture's mean colour is used instead");
    }
}

} // namespace difusa
