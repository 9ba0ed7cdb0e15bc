// MTL, the material libraries of Wavefront OBJ files.
#pragma once

#include <difusa/scene/material.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace difusa {

/// A `map_Kd` or `map_Ke` line. The image is not read here.
struct TextureUse {
    std::size_t material; ///< number in the library
    bool emission;        ///< map_Ke
    std::string file;     ///< as written
    std::uint32_t line;
    bool alone = false;                                        ///< there is no Kd, or Ke, to multiply
    bool clamp = false;                                        ///< -clamp on
    TexturePlacement placement = TexturePlacement::Identity(); ///< -s and -o
};

/// The definitions of the library, in order, and what the user should know about them.
struct MaterialLibrary {
    std::vector<Material> materials;
    std::vector<TextureUse> textures; ///< at most one of each kind per material
    std::vector<std::string> notes;
};

/// Reads `Kd` as the linear reflectance and `Ke` as the emitted radiosity in W/m², unclamped; a single number stands
/// for all three. `map_Kd` and `map_Ke` name images that multiply them; if such a material has no `Kd` or `Ke`, that is
/// 1. Coordinates on an image are those of the face times `-s` plus `-o`; beyond its edges it repeats, or with `-clamp
/// on` its edge is extended. With `illum 3`, `Ks` is the reflectance of a mirror or, if `Ns` is below 900, of a Phong
/// gloss with this exponent, as far as `Kd` leaves it. Transparency and everything else are ignored, with a note if
/// that changes the amount of light. Of two materials with the same name the first is used. A material with neither
/// `Kd` nor `map_Kd` keeps the default reflectance of `Material`, unless it is a mirror or a gloss: then it has no
/// diffuse part.
///
/// `file` is for messages. Throws InputError naming file and line if `Kd` or `Ke` is malformed or comes before any
/// `newmtl`.
MaterialLibrary parse_material_library(std::string_view content, const std::string& file);

} // namespace difusa
