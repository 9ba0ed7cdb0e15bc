// MTL, the material libraries of Wavefront OBJ files.
#pragma once

#include <difusa/scene/material.h>

#include <string>
#include <string_view>
#include <vector>

namespace difusa {

/// What the library defines, in its order, and what the user should know about it.
struct MaterialLibrary {
    std::vector<Material> materials;
    std::vector<std::string> notes;
};

/// Reads `Kd` as the linear reflectance and `Ke` as the emitted radiosity in W/m², uncapped; a single number
/// stands for three. Textures, transparency and everything else are not read; notes say so where that changes how
/// much light there is. Of two materials with one name the first counts. A material without `Kd` keeps the default
/// reflectance of `Material`.
///
/// `file` is for messages. Throws InputError naming file and line where `Kd` or `Ke` is malformed or comes before
/// any `newmtl`.
MaterialLibrary parse_material_library(std::string_view content, const std::string& file);

} // namespace difusa
