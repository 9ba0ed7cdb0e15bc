// One surface in many lights and colours.
#pragma once

#include <difusa/import/shapes.h>
#include <difusa/scene/sky_dome.h>

#include <support/lit_scenes.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace difusa::test {

/// Materials: 0 most of a room that is open above, 1 a panel that stands on its floor, 2 a small lamp that faces down,
/// 3 the far wall.
inline Mesh lightings_room() {
    Mesh mesh = rectangle(Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 2, 0), 3, 3);                // floor
    add(mesh, rectangle(Vec3(0, 0, 0), Vec3(0, 0, 1.5), Vec3(2, 0, 0)), 0);                  // y = 0
    add(mesh, rectangle(Vec3(0, 0, 0), Vec3(0, 2, 0), Vec3(0, 0, 1.5)), 0);                  // x = 0
    add(mesh, rectangle(Vec3(0, 2, 0), Vec3(2, 0, 0), Vec3(0, 0, 1.5), 4, 4), 3);            // y = 2
    add(mesh, lit::plain_box(Vec3(0.9, 0.5, 0), Vec3(1.0, 1.5, 0.6), 1, Front::outside), 1); // stands on the floor
    add(mesh, rectangle(Vec3(0.4, 0.4, 1.4), Vec3(0, 0.15, 0), Vec3(0.15, 0, 0)), 2);        // lamp
    mesh.corner_texture.resize(mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (int k = 0; k < 3; ++k) {
            const Vec3& p = mesh.corner(static_cast<Index>(t), k);
            mesh.corner_texture[t][static_cast<std::size_t>(k)] = TextureCoordinates(p.x() + p.y(), p.z() - p.y());
        }
    }
    return mesh;
}

inline std::shared_ptr<const Texture> checks() {
    Image image;
    image.width = image.height = 4;
    for (int i = 0; i < 16; ++i) {
        image.pixels.push_back({0.2F + 0.05F * static_cast<float>(i), i % 3 == 0 ? 0.9F : 0.1F, 0.5F});
    }
    return std::make_shared<Texture>(image);
}

inline Scene bare_room() {
    Scene scene = lit::scene_of(lightings_room(), 0.5);
    scene.materials.resize(4, scene.materials[0]);
    const char* const names[] = {"room", "panel", "lamp", "wall"};
    for (std::size_t m = 0; m < 4; ++m) {
        scene.materials[m].name = names[m];
    }
    return scene;
}

/// The same surface in different lights, and made of different materials.
inline std::vector<std::pair<std::string, Scene>> lightings() {
    std::vector<std::pair<std::string, Scene>> all;
    const auto next = [&](const std::string& name) -> Scene& {
        all.emplace_back(name, bare_room());
        return all.back().second;
    };
    next("dark but for the sky").sky = Rgb(1, 1, 1);
    next("an area light").materials[2].emission = Rgb(50, 40, 30);
    Scene& all_emit = next("everything emits");
    for (Material& material : all_emit.materials) {
        material.emission = Rgb(1, 2, 3);
        material.reflectance = Rgb(0.9, 0.1, 0.4);
    }
    Scene& textured = next("a textured emitter and textured walls");
    textured.materials[3].emission = Rgb(3, 2, 1);
    textured.materials[3].emission_texture = textured.materials[0].reflectance_texture = checks();
    Scene& pattern = next("a lamp with a pattern");
    pattern.materials[2].emission = Rgb(5, 5, 5);
    pattern.materials[2].emission_pattern = [](const Vec3& x) { return x.x(); };
    Scene& suns = next("suns and point lights on grey");
    suns.suns = {{Vec3(0.3, -1, 2).normalized(), Rgb::Constant(7)}, {Vec3::UnitZ(), Rgb::Constant(1)}};
    suns.point_lights = {{Vec3(1.5, 0.5, 1.0), Rgb::Constant(2)}};
    Scene& dome = next("a dome over black");
    dome.dome = std::make_shared<GradientSky>(Rgb(1, 2, 3), Rgb(3, 2, 1), Rgb(0.1, 0.1, 0.1), Vec3::UnitZ());
    for (Material& material : dome.materials) {
        material.reflectance = Rgb::Zero();
    }
    return all;
}

} // namespace difusa::test
