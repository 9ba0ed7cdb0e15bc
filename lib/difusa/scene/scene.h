// A scene: surface, materials, light.
#pragma once

#include <difusa/mesh/mesh.h>
#include <difusa/scene/lights.h>
#include <difusa/scene/material.h>

#include <memory>
#include <numbers>
#include <optional>
#include <vector>

namespace difusa {

struct Scene {
    Mesh mesh;
    std::vector<Material> materials; ///< indexed by Mesh::material
    std::vector<Sun> suns;
    std::vector<PointLight> point_lights;
    Rgb sky = Rgb::Zero(); ///< irradiance in W/m² of a surface that sees only the uniform sky (pi times its radiance)
    std::shared_ptr<const SkyDome> dome; ///< additional light from the sky, by direction; null: none
    /// Of a thermal scene. What its materials emit, and with it all solutions and fields, are then differences to what
    /// they would be if everything were at the reference temperature, and may be negative (scene/thermal.h).
    std::optional<ThermalSetting> thermal = {};

    /// Reflectance rho at a surface point, per channel, in [0,1].
    Rgb reflectance(const SurfacePoint& x) const;

    /// Emitted radiosity E at a surface point, W/m². Throws InputError if the emission pattern is not finite and
    /// nonnegative there.
    Rgb emission(const SurfacePoint& x) const;

    /// Of each material, 1 if a face has it, else 0. A scene file has a material for each name in a mesh file before
    /// its own replaces it; nothing depends on those that are left over.
    std::vector<char> used_materials() const;

    /// Whether some material that emits has a texture or pattern of emission.
    bool has_uneven_emitters() const;

    /// How many pixels of the texture of its emission a triangle shows, repeated ones included; 0 without a texture.
    double pixels_of_emission(Index triangle) const;

    /// Of each side (mesh/smooth_sides.h), 1 if it is joined to one of the same material along which a texture of the
    /// reflectance or the emission shows something else; empty if there is none.
    std::vector<char> texture_seams() const;

    /// Radiance arriving from the unit direction `towards` where rays hit nothing, W/(m² sr).
    Rgb sky_radiance(const Vec3& towards) const {
        return sky * std::numbers::inv_pi + (dome ? dome->radiance(towards) : Rgb(Rgb::Zero()));
    }

    bool has_sky() const { return dome != nullptr || (sky > 0.0).any(); }

    /// True if some face emits, be it less than nothing in a thermal scene.
    bool has_emitters() const;

    /// True if all reflectances and lights have equal channels, so that one channel suffices.
    bool is_grey() const;
};

/// Sets the mirrors of the mesh from the materials; `most`: Mirrors::most.
void settle_mirrors(Scene& scene, std::size_t most);

/// Sets the glossy surfaces of the mesh from the materials.
void settle_gloss(Scene& scene);

/// Materials with an emission that is not 0 in some channel.
std::vector<char> emitting_materials(const Scene& scene);

} // namespace difusa
