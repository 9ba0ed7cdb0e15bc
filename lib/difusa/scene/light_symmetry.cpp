#include <difusa/scene/light_symmetry.h>

#include <difusa/core/error.h>
#include <difusa/core/text.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace difusa {

namespace {

constexpr double same_direction = 1e-5;
constexpr double same_light = 1e-4; ///< of the largest
constexpr std::size_t sky_directions = std::size_t{1} << 16U;

/// Direction i of n that are spread evenly over the sphere.
Vec3 even_direction(std::size_t i, std::size_t n) {
    constexpr double golden_angle = 2.399963229728653;
    const double z = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / static_cast<double>(n);
    const double azimuth = golden_angle * static_cast<double>(i), r = std::sqrt(1.0 - z * z);
    return {r * std::cos(azimuth), r * std::sin(azimuth), z};
}

/// Whether a function of direction, with one value or three, is the same in each of these directions and its
/// reflection.
template <class Of> bool is_symmetric(const Repetition::Wall& wall, const std::vector<Vec3>& directions, const Of& of) {
    double largest = 0.0, difference = 0.0;
    for (const Vec3& there : directions) {
        const Rgb value = of(there), image = of(wall.turned(there));
        largest = std::max(largest, value.abs().maxCoeff());
        difference = std::max(difference, (value - image).abs().maxCoeff());
    }
    return difference <= same_light * largest;
}

std::vector<Vec3> even_directions(std::size_t n) {
    std::vector<Vec3> directions;
    for (std::size_t i = 0; i < n; ++i) {
        directions.push_back(even_direction(i, n));
    }
    return directions;
}

/// Everywhere, and in rings around the axis of the light, each at half the angle of the one before, for narrow beams.
std::vector<Vec3> directions_of(const PointLight& light) {
    constexpr std::size_t everywhere = 4096, rings = 16, in_ring = 16;
    std::vector<Vec3> directions = even_directions(everywhere);
    const Vec3 axis = light.direction.normalized(), u = axis.unitOrthogonal(), v = axis.cross(u);
    double angle = std::numbers::pi;
    for (std::size_t ring = 0; ring < rings; ++ring) {
        angle *= 0.5;
        for (std::size_t k = 0; k < in_ring; ++k) {
            // Not the same azimuths in all rings.
            const double azimuth =
                2.0 * std::numbers::pi * (static_cast<double>(k) + static_cast<double>(ring) / rings) / in_ring;
            directions.emplace_back(std::cos(angle) * axis +
                                    std::sin(angle) * (std::cos(azimuth) * u + std::sin(azimuth) * v));
        }
    }
    return directions;
}

/// The suns of the light group of one that are in a direction, together: the groups are symmetric each.
Rgb irradiance_from(const Scene& scene, const Sun& one, const Vec3& towards) {
    Rgb sum = Rgb::Zero();
    for (const Sun& sun : scene.suns) {
        if (sun.name == one.name && (sun.towards - towards).norm() <= same_direction &&
            std::abs(sun.disc - one.disc) <= same_light * one.disc) {
            sum += sun.irradiance;
        }
    }
    return sum;
}

void check_suns(const Scene& scene, const Repetition::Wall& wall, const std::string& plane) {
    for (const Sun& sun : scene.suns) {
        const Vec3 there = wall.turned(sun.towards);
        const Rgb here = irradiance_from(scene, sun, sun.towards);
        if (((here - irradiance_from(scene, sun, there)).abs() > same_light * here.maxCoeff()).any()) {
            throw InputError("the sun towards " + coordinates(sun.towards) + " is not in " + plane +
                             ": the light has to be symmetric; add its mirror image, a sun of the same name towards " +
                             coordinates(there) + ", or bake the whole scene");
        }
    }
}

void check_point_light(const PointLight& light, const Repetition::Wall& wall, double touching,
                       const std::string& plane) {
    const std::string name = "the light at " + coordinates(light.position);
    const double height = wall.height(light.position);
    if (height < -touching) {
        throw InputError(name + " is " + text_of(-height) + " m behind " + plane +
                         ": give its mirror image, which shines from there as well");
    }
    if (height > touching) {
        if (light.is_extended() && light.radius() > height + touching) {
            throw InputError(name + " has an opening that may reach behind " + plane +
                             ": move it away, or into the plane");
        }
        return;
    }
    const auto along = [&](const Vec3& axis) { return std::abs(wall.normal.dot(axis)); };
    const bool lies_askew =
        light.is_extended() && !(along(light.c0) <= same_direction || along(light.c90) <= same_direction ||
                                 (light.is_round && light.half_length == light.half_width));
    if (lies_askew || !is_symmetric(wall, directions_of(light),
                                    [&](const Vec3& away) { return Rgb(Rgb::Constant(light.falloff(away))); })) {
        throw InputError(name + " is on " + plane +
                         " and does not send the same light to both sides: turn it, or move it off the plane");
    }
}

} // namespace

void check_light_symmetry(const Scene& scene) {
    const auto& walls = scene.mesh.repetition.walls;
    const double touching = 1e-6 * scene.mesh.diameter();
    for (std::size_t i = 0; i < walls.size() && walls[i].reflects; ++i) { // planes come before periods
        const std::string plane = "symmetry plane " + std::to_string(i + 1);
        check_suns(scene, walls[i], plane);
        if (scene.dome && !is_symmetric(walls[i], even_directions(sky_directions),
                                        [&](const Vec3& towards) { return scene.dome->radiance(towards); })) {
            throw InputError("the sky is not symmetric about " + plane +
                             ": give a uniform sky, or one whose sun is in the plane, or bake the whole scene");
        }
        for (const PointLight& light : scene.point_lights) {
            if ((light.intensity > 0.0).any()) {
                check_point_light(light, walls[i], touching, plane);
            }
        }
    }
}

} // namespace difusa
