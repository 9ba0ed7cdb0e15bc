#include <difusa/repair/texture_coordinates.h>

#include <difusa/repair/findings.h>

#include <algorithm>

namespace difusa {

void settle_textures(PolygonSoup& soup) {
    const std::size_t materials = soup.materials.size();
    if (std::none_of(soup.materials.begin(), soup.materials.end(), is_textured)) {
        return;
    }
    std::vector<Index> plain(materials, none); // the replacement for each material
    std::size_t faces = 0, first = 0;
    for (std::size_t f = 0; f < soup.face_count(); ++f) {
        const Index m = soup.face_material[f];
        if (m == none || !is_textured(soup.materials[m])) {
            continue;
        }
        const auto begin = static_cast<std::ptrdiff_t>(soup.first_corner[f]);
        const auto end = static_cast<std::ptrdiff_t>(soup.first_corner[f + 1]);
        if (!soup.corner_texture.empty() &&
            std::all_of(soup.corner_texture.begin() + begin, soup.corner_texture.begin() + end, is_placed)) {
            continue;
        }
        if (plain[m] == none) {
            plain[m] = static_cast<Index>(soup.materials.size());
            Material material = soup.materials[m];
            if (material.reflectance_texture) {
                material.reflectance *= material.reflectance_texture->mean();
                material.reflectance_texture = nullptr;
            }
            if (material.emission_texture) {
                material.emission *= material.emission_texture->mean();
                material.emission_texture = nullptr;
            }
            soup.materials.push_back(std::move(material));
        }
        soup.face_material[f] = plain[m];
        first = faces++ == 0 ? f : first;
    }
    if (faces > 0) {
        soup.notes.push_back(
            "faces without texture coordinates whose material has a texture: " + std::to_string(faces) +
            " (first: " + face_name(soup, first) + "); the texture's mean colour is used instead");
    }
}

} // namespace difusa
