#include "scenes.h"

#include <cmath>
#include <numbers>

namespace scenes {

Surface bowl() {
    Surface bowl;
    bowl.remarks = {
        "The inside of a sphere of radius 1 without the quarter of its surface that is highest.",
        "Made by data/generator/bowl.cpp.",
        "Exact answer: seen from any point of a sphere, a part of its surface has a form factor of its share of the",
        "area. The bowl is f = 3/4 of the sphere, so under a uniform sky of irradiance 1 its irradiance is the same",
        "all over, (1 - f) / (1 - f rho): with its reflectance of 0.8 it is 0.625, straight from the sky 0.25.",
    };
    const unsigned material = bowl.add({"bowl", {0.8, 0.8, 0.8}, {}});
    const int rings = 32, sectors = 64;
    // From the bottom up to 120 degrees, where the height is 1/2: three quarters of the sphere's height and area.
    const auto at = [&](int ring, int sector) -> Vector {
        if (ring == 0) {
            return {0.0, 0.0, -1.0};
        }
        const double polar = 2.0 / 3.0 * std::numbers::pi * ring / rings;
        const double angle = 2.0 * std::numbers::pi * (sector % sectors) / sectors;
        return {std::sin(polar) * std::cos(angle), std::sin(polar) * std::sin(angle), -std::cos(polar)};
    };
    for (int ring = 0; ring < rings; ++ring) {
        for (int sector = 0; sector < sectors; ++sector) {
            const Vector a = at(ring, sector), b = at(ring + 1, sector), c = at(ring + 1, sector + 1);
            if (ring == 0) {
                bowl.polygon({a, b, c}, material);
            } else {
                bowl.polygon({a, b, c, at(ring, sector + 1)}, material);
            }
        }
    }
    return bowl;
}

} // namespace scenes
