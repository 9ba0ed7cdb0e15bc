// Faces whose material has a texture, and what becomes of those that do not say where on it they lie.
#pragma once

#include <difusa/repair/polygon_soup.h>

namespace difusa {

inline bool is_textured(const Material& material) {
    return material.reflectance_texture != nullptr || material.emission_texture != nullptr;
}

/// True for texture coordinates at which a texture can be looked up: finite, and small enough to tell pixels apart.
inline bool is_placed(const TextureCoordinates& coordinates) {
    constexpr double largest = 1e9;
    return coordinates.cwiseAbs().maxCoeff() <= largest; // false for NaN
}

/// Faces of textured materials with a corner that has no texture coordinates get a material of the same name in which
/// the mean colour of each texture stands for it, and the soup a note. Readers end with it.
void settle_textures(PolygonSoup& soup);

} // namespace difusa
