#include "scenes.h"

#include <cmath>
#include <numbers>

namespace scenes {

Surface ball_over_disc() {
    Surface scene;
    scene.remarks = {
        "A ball of radius 5 that hangs with its centre 20 over the middle of a disc of radius 40.",
        "The example of the dissertation's chapter 7. Made by data/generator/ball_over_disc.cpp.",
        "The points lie on the true ball and disc, so both areas are about a thousandth too small.",
    };
    const unsigned material = scene.add({"both", {0.9, 0.9, 0.9}, {}});
    const double disc_radius = 40.0;
    const int sectors = 96, rings = 8;
    const auto at = [&](int ring, int sector) -> Vector {
        const double angle = 2.0 * std::numbers::pi * (sector % sectors) / sectors;
        const double radius = disc_radius * ring / rings;
        return {radius * std::cos(angle), radius * std::sin(angle), 0.0};
    };
    for (int sector = 0; sector < sectors; ++sector) {
        scene.polygon({{0.0, 0.0, 0.0}, at(1, sector), at(1, sector + 1)}, material);
    }
    for (int ring = 1; ring < rings; ++ring) {
        for (int sector = 0; sector < sectors; ++sector) {
            scene.polygon({at(ring, sector), at(ring + 1, sector), at(ring + 1, sector + 1), at(ring, sector + 1)},
                          material);
        }
    }
    add_ball(scene, {0.0, 0.0, 20.0}, 5.0, 20, material);
    return scene;
}

} // namespace scenes
