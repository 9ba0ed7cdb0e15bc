// Handles faces that have a textured material but no texture coordinates that a colour could be looked up at.
#pragma once

#include <difusa/repair/polygon_soup.h>

namespace difusa {

inline bool is_textured(const Material& material) {
    return material.reflectance_texture != nullptr || material.emission_texture != nullptr;
}

/// True for texture coordinates usable for a lookup: finite, and small enough to resolve pixels.
inline bool is_placed(const TextureCoordinates& coordinates) {
    constexpr double largest = 1e9;
    return coordinates.cwiseAbs().maxCoeff() <= largest; // false for NaN
}

/// True if these coordinates are usable on each of the material's textures, where that has placed them.
inline bool is_placed_on(const Material& material, const TextureCoordinates& coordinates) {
    return is_placed(coordinates) &&
           (!material.reflectance_texture || is_placed(material.reflectance_texture->on_image(coordinates))) &&
           (!material.emission_texture || is_placed(material.emission_texture->on_image(coordinates)));
}

/// Faces of textured materials with a corner that has no usable texture coordinates, or that a texture's placement
/// takes too far away, get a material of the same name in which each texture is replaced by its mean colour, and the
/// soup gets a note. Called last by readers.
void settle_textures(PolygonSoup& soup);

} // namespace difusa
