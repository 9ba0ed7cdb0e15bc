// A scene: surface, materials, light.
#pragma once

#include <difusa/scene/material.h>
#include <difusa/scene/mesh.h>

#include <vector>

namespace difusa {

struct Scene {
    Mesh mesh;
    std::vector<Material> materials; ///< Mesh::material numbers them
    Rgb sky = Rgb::Zero(); ///< irradiance in W/m² of a surface that sees nothing but sky (pi times its radiance)

    /// Reflectance rho at a surface point, per channel, in [0,1].
    Rgb reflectance(const SurfacePoint& x) const;

    /// Emitted radiosity E at a surface point, W/m².
    const Rgb& emission(const SurfacePoint& x) const { return materials[mesh.material[x.face]].emission; }

    bool has_sky() const { return (sky > 0.0).any(); }

    /// True if some face emits.
    bool has_emitters() const;

    /// True if all reflectances and lights have equal channels, so that one channel tells everything.
    bool is_grey() const;
};

} // namespace difusa
