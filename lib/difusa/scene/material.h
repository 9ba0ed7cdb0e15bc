// What a surface does with light.
#pragma once

#include <difusa/core/types.h>

#include <functional>
#include <string>

namespace difusa {

/// A diffuse material. Every face of a scene has one.
struct Material {
    std::string name;                     ///< as in the file, or made up by the reader ("colour 3", "default")
    Rgb reflectance = Rgb::Constant(0.5); ///< rho, linear, in [0,1]
    Rgb emission = Rgb::Zero();           ///< E, emitted radiosity in W/m², any value >= 0
    bool vertex_colours = false;          ///< rho is interpolated from Mesh::corner_reflectance instead
    /// A factor >= 0 on the emission by place; null: 1 everywhere.
    std::function<double(const Vec3& position)> emission_pattern = {};
};

} // namespace difusa
