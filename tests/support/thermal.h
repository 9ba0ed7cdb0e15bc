// Thermal scenes for tests.
#pragma once

#include <difusa/bake.h>
#include <difusa/import/shapes.h>
#include <difusa/mesh/mesh.h>

#include <support/lit_scenes.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace difusa::test {

inline Material thermal_material(Thermal::Given given, double value, double emissivity, const std::string& name = "") {
    Material material;
    material.name = name;
    material.thermal = Thermal{given, value, emissivity};
    return material;
}

inline Material at_temperature(double kelvins, double emissivity, const std::string& name = "") {
    return thermal_material(Thermal::Given::temperature, kelvins, emissivity, name);
}

inline Material with_net_flux(double flux, double emissivity, const std::string& name = "") {
    return thermal_material(Thermal::Given::net_flux, flux, emissivity, name);
}

inline Material with_heat(double watts, double emissivity, const std::string& name = "") {
    return thermal_material(Thermal::Given::heat, watts, emissivity, name);
}

inline Scene thermal_scene(Mesh mesh, std::vector<Material> materials, std::optional<double> surroundings = {}) {
    Scene scene;
    scene.mesh = std::move(mesh);
    scene.materials = std::move(materials);
    if (surroundings) {
        scene.thermal = ThermalSetting{surroundings};
    }
    return scene;
}

/// The unit cube seen from inside, materials 0 to 5: x low, x high, y low, y high, z low, z high.
inline Mesh closed_cube(int n = 1) {
    return difusa::box(Vec3::Zero(), Vec3::Ones(), n, Front::inside);
}

/// Two plates, materials 0 (z = 0, facing up) and 1 (z = gap), between perfect mirrors, material 2: infinite plates.
inline Mesh mirrored_plates(double gap) {
    Mesh mesh = difusa::box(Vec3::Zero(), Vec3(1, 1, gap), 1, Front::inside);
    for (Index& m : mesh.material) {
        m = m == 4 ? 0 : m == 5 ? 1 : 2;
    }
    return mesh;
}

inline Material perfect_mirror() {
    Material material;
    material.name = "mirror";
    material.reflectance = Rgb::Zero();
    material.mirror = Rgb::Ones();
    return material;
}

/// What a material of the result comes to.
inline const ThermalSurface& surface_of(const BakeResult& result, Index material) {
    for (const ThermalSurface& surface : result.thermal->surfaces) {
        if (surface.material == material) {
            return surface;
        }
    }
    throw InternalError("no such material in the result");
}

} // namespace difusa::test
