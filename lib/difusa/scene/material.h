// What a surface does with light.
#pragma once

#include <difusa/core/types.h>
#include <difusa/scene/texture.h>

#include <functional>
#include <memory>
#include <string>

namespace difusa {

/// A diffuse material. Every face of a scene has one.
struct Material {
    std::string name;                     ///< as in the file, or made up by the reader ("colour 3", "default")
    Rgb reflectance = Rgb::Constant(0.5); ///< rho, linear, in [0,1]
    Rgb emission = Rgb::Zero();           ///< E, emitted radiosity in W/m², any value >= 0
    bool vertex_colours = false;          ///< rho is interpolated from Mesh::corner_reflectance instead
    bool double_sided = false;            ///< the diagnosis gives its faces a back that is a front too
    std::shared_ptr<const Texture> reflectance_texture = {}; ///< a factor on rho by Mesh::corner_texture; null: 1
    std::shared_ptr<const Texture> emission_texture = {};    ///< a factor on E likewise
    std::string light_group = {};                            ///< of what it emits; empty: its name
    /// A factor >= 0 on the emission by place; null: 1 everywhere.
    std::function<double(const Vec3& position)> emission_pattern = {};

    /// True if E is not the same all over its faces.
    bool emits_unevenly() const { return emission_pattern != nullptr || emission_texture != nullptr; }
};

} // namespace difusa
