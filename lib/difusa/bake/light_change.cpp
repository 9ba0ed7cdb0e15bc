#include <difusa/bake/light_change.h>

#include <difusa/bake/names.h>
#include <difusa/bake/options.h>
#include <difusa/core/error.h>
#include <difusa/core/text.h>
#include <difusa/scene/light_groups.h>
#include <difusa/scene/sky_dome.h>
#include <difusa/scene/sound_scene.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace difusa {

namespace {

/// Calls `act` for each material of this name. Throws UsageError unless a face has one.
template <class Act> void for_materials(Scene& scene, const char* option, const std::string& name, const Act& act) {
    const std::vector<std::string> in_use = names_of_materials_in_use(scene);
    bool found = false;
    for (Material& material : scene.materials) {
        if (material.name == name) {
            act(material);
            found = true;
        }
    }
    if (std::find(in_use.begin(), in_use.end(), name) == in_use.end()) {
        throw UsageError(std::string(option) + ": " +
                         (found ? "no face has the material `" + name + "`" : unknown_name("material", name, in_use)));
    }
}

void scale(Rgb& light, const std::string& name, double factor) {
    light *= factor;
    if (!is_light(light)) {
        throw UsageError("--scale " + name + ": the light times " + text_of(factor) +
                         " is not 0, nor from 1e-100 to 1e100");
    }
}

void scale_group(Scene& scene, const LightSets& sets, const std::string& name, double factor) {
    if (!(factor >= 0.0) || !std::isfinite(factor)) {
        throw UsageError("--scale " + name + ": the factor must be a finite number of at least 0");
    }
    const auto found = std::find(sets.names.begin(), sets.names.end(), name);
    if (found == sets.names.end() || name.empty()) {
        throw UsageError("--scale: " + unknown_name("light group", name, sets.names));
    }
    const auto set = static_cast<Index>(found - sets.names.begin());
    // What does not shine belongs to no set, and stays dark.
    for (std::size_t m = 0; m < scene.materials.size(); ++m) {
        if (sets.material[m] == set) {
            scale(scene.materials[m].emission, name, factor);
        }
    }
    for (std::size_t i = 0; i < scene.suns.size(); ++i) {
        if (sets.sun[i] == set) {
            scale(scene.suns[i].irradiance, name, factor);
        }
    }
    for (std::size_t i = 0; i < scene.point_lights.size(); ++i) {
        if (sets.point[i] == set) {
            scale(scene.point_lights[i].intensity, name, factor);
        }
    }
    if (sets.sky == set && scene.has_sky()) {
        scale(scene.sky, name, factor);
        if (scene.dome) {
            scene.dome = factor > 0.0 ? std::make_shared<ScaledSky>(scene.dome, factor) : nullptr;
        }
    }
}

void set_reflectance(Material& material, const Rgb& reflectance) {
    const bool textured = material.reflectance_texture != nullptr;
    const Rgb brightest = textured ? Rgb(material.reflectance_texture->brightest() * reflectance) : reflectance;
    if (!((reflectance >= 0.0) && (reflectance <= 1.0) && (brightest <= 1.0)).all()) {
        throw UsageError("--reflectance " + material.name + ": must be from 0 to 1" +
                         (textured ? ", also times its texture" : ""));
    }
    if (!material.reflects_at_most_all(brightest)) {
        throw UsageError("--reflectance " + material.name +
                         ": with what it reflects specularly, more than all of the light would be reflected");
    }
    material.reflectance = reflectance;
    material.vertex_colours = false;
}

} // namespace

void scale_lights(const LightFactors& factors, Scene& scene) {
    const LightSets sets = light_groups(scene); // what a factor of 0 turns off keeps its name
    for (const auto& [name, factor] : factors) {
        scale_group(scene, sets, name, factor);
    }
}

void change_light(const LightChange& change, Scene& scene) {
    const LightSets before = light_groups(scene);
    for (const auto& wanted : change.emission) {
        if (!is_light(wanted.second)) {
            throw UsageError("--emission " + wanted.first + ": must be 0, or from 1e-100 to 1e100");
        }
        for_materials(scene, "--emission", wanted.first,
                      [&](Material& material) { material.emission = wanted.second; });
    }
    for (const auto& wanted : change.reflectance) {
        for_materials(scene, "--reflectance", wanted.first,
                      [&](Material& material) { set_reflectance(material, wanted.second); });
    }
    const LightSets after = light_groups(scene);
    const auto has = [](const LightSets& sets, const std::string& name) {
        return std::find(sets.names.begin(), sets.names.end(), name) != sets.names.end();
    };
    LightFactors factors = change.scale;
    std::erase_if(factors, [&](const auto& factor) { // of what has just been turned off, nothing is left to scale
        return has(before, factor.first) && !has(after, factor.first);
    });
    scale_lights(factors, scene);
}

} // namespace difusa
