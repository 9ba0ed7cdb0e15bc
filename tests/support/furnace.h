// A closed box that emits the same light everywhere, and its bakes.
#pragma once

#include <difusa/bake.h>
#include <difusa/import/shapes.h>

#include <support/plugins.h>

#include <string>
#include <utility>

namespace difusa::test {

/// The unit cube seen from inside. Each side has a material of its own, "side 0" to "side 5".
inline Scene furnace(double rho, double E) {
    Scene scene;
    scene.mesh = difusa::box(Vec3::Zero(), Vec3::Ones(), 1, Front::inside);
    for (int face = 0; face < 6; ++face) {
        Material material;
        material.name = "side " + std::to_string(face);
        material.reflectance = Rgb::Constant(rho);
        material.emission = Rgb::Constant(E);
        scene.materials.push_back(material);
    }
    return scene;
}

inline BakeResult baked(Scene scene, const BakeOptions& options) {
    return bake(registry(), std::move(scene), "scene", options, Execution{});
}

} // namespace difusa::test
