// MTL, the material libraries of Wavefront OBJ files.
#pragma once

#include <difusa/scene/material.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace difusa {

/// A `map_Kd` or `map_Ke` line. The picture is not read here.
struct TextureUse {
    std::size_t material; ///< number in the library
    bool emission;        ///< map_Ke
    std::string file;     ///< as written
    std::uint32_t line;
    bool alone = false;                                        ///< there is no Kd, or Ke, whose factor it is
    bool clamp = false;                                        ///< -clamp on
    TexturePlacement placement = TexturePlacement::Identity(); ///< -s and -o
};

/// What the library defines, in its order, and what the user should know about it.
struct MaterialLibrary {
    std::vector<Material> materials;
    std::vector<TextureUse> textures; ///< at most one of each kind for a material
    std::vector<std::string> notes;
};

/// Reads `Kd` as the linear reflectance and `Ke` as the emitted radiosity in W/m², uncapped; a single number
/// stands for three. `map_Kd` and `map_Ke` name pictures that are factors on them; where such a material has no `Kd`
/// or `Ke`, that is 1. Coordinates on a picture are those of the face times `-s` plus `-o`; beyond its edges it repeats
/// itself, or with `-clamp on` its edge goes on. Mirrors, transparency and everything else are not read; notes say so
/// where that changes how much light there is. Of two materials with one name the first counts. A material without `Kd`
/// and `map_Kd` keeps the default reflectance of `Material`.
///
/// `file` is for messages. Throws InputError naming file and line where `Kd` or `Ke` is malformed or comes before
/// any `newmtl`.
MaterialLibrary parse_material_library(std::string_view content, const std::string& file);

} // namespace difusa
