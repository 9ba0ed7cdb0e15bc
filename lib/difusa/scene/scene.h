// A scene: surface, materials, light.
#pragma once

#include <difusa/scene/material.h>
#include <difusa/scene/mesh.h>

#include <vector>

namespace difusa {

/// Light from one direction, infinitely far away.
struct Sun {
    Vec3 towards = Vec3::UnitZ(); ///< unit, from the surface to the sun
    Rgb irradiance = Rgb::Zero(); ///< of a surface that faces it, W/m²
};

struct Scene {
    Mesh mesh;
    std::vector<Material> materials; ///< Mesh::material numbers them
    std::vector<Sun> suns;
    Rgb sky = Rgb::Zero(); ///< irradiance in W/m² of a surface that sees nothing but sky (pi times its radiance)

    /// Reflectance rho at a surface point, per channel, in [0,1].
    Rgb reflectance(const SurfacePoint& x) const;

    /// The factor of the material's pattern at a surface point; 1 where it has none.
    double emission_factor(const SurfacePoint& x) const {
        const Material& material = materials[mesh.material[x.face]];
        return material.emission_pattern ? material.emission_pattern(x.position) : 1.0;
    }

    /// Emitted radiosity E at a surface point, W/m².
    Rgb emission(const SurfacePoint& x) const { return materials[mesh.material[x.face]].emission * emission_factor(x); }

    bool has_sky() const { return (sky > 0.0).any(); }

    /// True if some face emits.
    bool has_emitters() const;

    /// True if all reflectances and lights have equal channels, so that one channel tells everything.
    bool is_grey() const;
};

} // namespace difusa
