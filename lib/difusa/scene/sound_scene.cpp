#include <difusa/scene/sound_scene.h>

#include <difusa/core/error.h>
#include <difusa/core/text.h>

#include <cmath>
#include <cstddef>

namespace difusa {

bool is_light(const Rgb& c) {
    return (c == 0.0 || (c >= 1e-100 && c <= 1e100)).all(); // false for NaN
}

bool is_sound(const Sun& sun) {
    return is_unit(sun.towards) && is_light(sun.irradiance) && sun.disc >= 0.0 && sun.disc < 1.0;
}

bool is_sound(const PointLight& light) {
    return light.position.allFinite() && is_unit(light.direction) && is_light(light.intensity) &&
           light.cos_outer >= -1.0 && light.cos_outer <= light.cos_inner && light.cos_inner <= 1.0 &&
           is_unit(light.c0) && is_unit(light.c90) && light.half_length >= 0.0 && light.half_width >= 0.0 &&
           std::isfinite(light.radius());
}

std::string name_of(const Scene& scene, Index material) {
    const std::string& name = scene.materials[material].name;
    return name.empty() ? "material number " + std::to_string(material) : "the material " + name;
}

void check_materials_and_lights(const Scene& scene, const std::string& name) {
    const auto refuse = [&](const std::string& why) { throw InputError(name + ": " + why); };
    const Mesh& mesh = scene.mesh;
    for (std::size_t t = 0; t < mesh.corner_reflectance.size(); ++t) {
        for (const Rgb& colour : mesh.corner_reflectance[t]) {
            if (!((colour >= 0.0) && (colour <= 1.0)).all()) {
                refuse("triangle " + std::to_string(t) + " has a vertex colour outside [0,1]: " + text_of(colour));
            }
            const Material& material = scene.materials[mesh.material[t]];
            if (material.vertex_colours && !material.reflects_at_most_all(colour)) {
                refuse("triangle " + std::to_string(t) +
                       " reflects more than all of the light, specularly and with its vertex "
                       "colour " +
                       text_of(colour));
            }
        }
    }
    if (!is_light(scene.sky)) {
        refuse("the sky's irradiance is neither 0 nor from 1e-100 to 1e100");
    }
    for (Index number = 0; number < scene.materials.size(); ++number) {
        const Material& material = scene.materials[number];
        // What thermal materials emit follows from their temperatures.
        if (!((material.reflectance >= 0.0) && (material.reflectance <= 1.0)).all() ||
            !(material.thermal || is_light(material.emission))) {
            refuse(name_of(scene, number) +
                   " has a reflectance outside [0,1], or an emission that is neither 0 nor from 1e-100 to 1e100");
        }
        if (!(material.mirror >= 0.0).all() ||
            !material.reflects_at_most_all(material.vertex_colours ? Rgb(Rgb::Zero())
                                                                   : material.brightest_reflectance())) {
            refuse(name_of(scene, number) + " reflects more than all of the light, diffusely and specularly together");
        }
        if (material.gloss && !is_sound(*material.gloss)) {
            refuse(name_of(scene, number) + " has a gloss with a reflectance outside [0,1], an exponent "
                                            "outside [1,10000] or a roughness outside [0.03,1]");
        }
        if (material.reflectance_texture &&
            !(material.reflectance_texture->brightest() * material.reflectance <= 1.0).all()) {
            refuse(name_of(scene, number) + " has a texture that makes its reflectance exceed 1");
        }
    }
    for (const Sun& sun : scene.suns) {
        if (!is_sound(sun)) {
            refuse("a sun has a direction of non-unit length, or an irradiance that is neither 0 nor from 1e-100 to "
                   "1e100");
        }
    }
    for (const PointLight& light : scene.point_lights) {
        if (!is_sound(light)) {
            refuse("a point light has a non-finite position, an axis of non-unit length, an intensity that is neither "
                   "0 nor from 1e-100 to 1e100, or an inner cone wider than the outer one");
        }
    }
}

} // namespace difusa
