// The integral of a sky's light over the hemisphere.
#pragma once

#include <difusa/algebra/quadrature.h>
#include <difusa/core/types.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace difusa {

/// The irradiance of level ground by `radiance(towards)`, which is symmetric about the vertical plane of the sun and
/// may have a kink at it: azimuths are counted from the sun, and heights divided there, with `nodes` in each direction.
/// `up` and `sun`: unit, the sun not below the horizon.
template <class Radiance>
double level_irradiance(const Vec3& up, const Vec3& sun, std::size_t nodes, const Radiance& radiance) {
    const QuadratureRule rule = gauss_legendre(nodes);
    const Vec3 level = sun - sun.dot(up) * up;
    const Vec3 ahead = level.norm() > 1e-9 ? Vec3(level.normalized()) : Vec3(up.unitOrthogonal());
    const Vec3 aside = up.cross(ahead);
    double sum = 0.0;
    const auto add_band = [&](double from, double to) {
        for_each_node(rule, from, to, [&](double height, double of_height) {
            for_each_node(rule, 0.0, std::numbers::pi, [&](double azimuth, double of_azimuth) {
                const Vec3 towards =
                    std::sin(height) * up + std::cos(height) * (std::cos(azimuth) * ahead + std::sin(azimuth) * aside);
                sum += 2.0 * of_height * of_azimuth * std::sin(height) * std::cos(height) * radiance(towards);
            });
        });
    };
    const double at_sun = std::asin(std::clamp(sun.dot(up), 0.0, 1.0));
    add_band(0.0, at_sun);
    add_band(at_sun, 0.5 * std::numbers::pi);
    return sum;
}

} // namespace difusa
