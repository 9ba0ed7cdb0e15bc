#include "blocks.h"
#include "scenes.h"

namespace scenes {

Surface courtyard() {
    Surface yard;
    yard.remarks = {
        "A courtyard open to the sky: an arcade before a gallery, steps to a terrace, a bench, a gate.",
        "Lengths are in metres, z is up. Made up for this project by data/generator/courtyard.cpp.",
        "Its walls are warm in colour, so that the light they pass on to the plaster and the pavement shows.",
    };
    const unsigned pavement = yard.add({"pavement", {0.55, 0.50, 0.43}, {}});
    const unsigned plaster = yard.add({"plaster", {0.80, 0.77, 0.70}, {}});
    const unsigned ochre = yard.add({"ochre", {0.72, 0.48, 0.22}, {}});
    const unsigned terracotta = yard.add({"terracotta", {0.64, 0.24, 0.13}, {}});
    const unsigned stone = yard.add({"stone", {0.62, 0.60, 0.56}, {}});

    const double length = 12.0, depth = 10.0, wall = 0.4, top = 4.8;
    const double roof = 3.8, roof_top = 4.2, spring = 2.2;
    const double arcade_front = 6.8, arcade_back = 7.2;
    const double pillar = 0.48, opening = 2.2;

    Blocks blocks({0.0, 0.0, -0.2}, {length, depth, top + 0.2});
    blocks.fill({0.0, 0.0, -0.2}, {length, depth, 0.0}, pavement);
    blocks.fill({0.0, 0.0, 0.0}, {length, wall, top}, ochre);
    blocks.fill({0.0, depth - wall, 0.0}, {length, depth, top}, ochre);
    blocks.fill({0.0, wall, 0.0}, {wall, depth - wall, top}, terracotta);
    blocks.fill({length - wall, wall, 0.0}, {length, depth - wall, top}, ochre);
    blocks.carve({length - wall, 3.2, 0.0}, {length, 4.8, spring}); // the gate

    // The gallery: roof, arcade wall, and the arches in it.
    blocks.fill({wall, arcade_front, roof}, {length - wall, depth - wall, roof_top}, plaster);
    blocks.fill({wall, arcade_front, 0.0}, {length - wall, arcade_back, roof}, plaster);
    for (int k = 0; k < 4; ++k) {
        const double left = wall + pillar + k * (opening + pillar);
        blocks.carve({left, arcade_front, 0.0}, {left + opening, arcade_back, spring});
        blocks.arch({left, arcade_front, spring}, {left + opening, arcade_back, roof}, 16, plaster);
    }

    // The terrace and its steps, from pillar to pillar, so that no joint runs into an arch.
    const double left = wall + 2.0 * pillar + opening, right = length - left;
    blocks.fill({left, wall, 0.0}, {right, 2.4, 0.2}, stone);
    blocks.fill({left, wall, 0.2}, {right, 2.0, 0.4}, stone);
    blocks.fill({left, wall, 0.4}, {right, 1.6, 0.6}, stone);

    // A bench along the terracotta wall, and a plinth before the middle pillar.
    blocks.fill({wall, 3.2, 0.0}, {wall + pillar, 5.6, 0.45}, stone);
    blocks.fill({0.5 * (length - pillar), 4.4, 0.0}, {0.5 * (length + pillar), 4.88, 1.2}, plaster);
    blocks.add_to(yard);
    return yard;
}

} // namespace scenes
