// Whether the materials and lights of a scene that a program has made are possible.
#pragma once

#include <difusa/scene/scene.h>

#include <cmath>
#include <string>

namespace difusa {

/// True if its length is 1, to six digits.
inline bool is_unit(const Vec3& v) {
    return std::abs(v.norm() - 1.0) < 1e-6;
}

/// True if it has a direction of unit length and an irradiance that is_light.
bool is_sound(const Sun& sun);

/// Likewise, with a cone that is not inside out.
bool is_sound(const PointLight& light);

/// True if each channel is 0, or from 1e-100 to 1e100: the squares of errors far below it must neither underflow nor
/// overflow.
bool is_light(const Rgb& c);

/// "the material red", or by its number if it has no name.
std::string name_of(const Scene& scene, Index material);

/// Throws InputError, which begins with `name`, for a vertex colour or reflectance outside [0,1], more than all of the
/// light reflected, a gloss that is not sound, and light that is negative or beyond what can be computed with
/// (is_light), or comes from a direction of non-unit length. Materials exist for all triangles.
void check_materials_and_lights(const Scene& scene, const std::string& name);

} // namespace difusa
