#include "blocks.h"
#include "scenes.h"

namespace scenes {

Scene greenhouse_row() {
    Scene scene;
    Surface& house = scene.surface;
    house.remarks = {
        "Half a bay of a greenhouse of many spans, from the ridge to the gutter: planes of symmetry stand under both,",
        "and the bay repeats along the ridge. The glass is left out. Lengths are in metres, z is up.",
        "Made up for this project by data/generator/greenhouse_row.cpp.",
    };
    const unsigned soil = house.add({"soil", {0.16, 0.11, 0.07}, {}});
    const unsigned path = house.add({"path", {0.45, 0.44, 0.42}, {}});
    const unsigned metal = house.add({"metal", {0.62, 0.63, 0.64}, {}});
    const unsigned crop = house.add({"crop", {0.06, 0.16, 0.05}, {}});

    const double span = 3.2, bay = 4.0;
    Blocks blocks({0.0, 0.0, -0.5}, {span, bay, 6.0});
    blocks.fill({0.0, 0.0, -0.5}, {span, bay, 0.0}, soil);
    blocks.fill({0.0, 0.0, -0.5}, {0.45, bay, 0.0}, path);
    blocks.fill({span - 0.35, 0.0, -0.5}, {span, bay, 0.0}, path);
    // Two benches with their crop.
    for (const double x : {0.45, 1.75}) {
        blocks.fill({x, 0.0, 0.70}, {x + 1.0, bay, 0.76}, metal);
        for (const double y : {0.25, 2.25}) {
            blocks.fill({x + 0.1, y, 0.76}, {x + 0.9, y + 1.5, 1.15}, crop);
            blocks.fill({x + 0.45, y + 0.7, 0.0}, {x + 0.55, y + 0.8, 0.70}, metal);
        }
    }
    // Frame: half a post under half a gutter, half a ridge, and a beam between them.
    blocks.fill({span - 0.06, 1.94, 0.0}, {span, 2.06, 4.0}, metal);
    blocks.fill({span - 0.12, 0.0, 4.0}, {span, bay, 4.18}, metal);
    blocks.fill({0.0, 0.0, 4.85}, {0.05, bay, 4.97}, metal);
    blocks.fill({0.0, 1.96, 3.86}, {span - 0.06, 2.04, 4.0}, metal);
    blocks.add_to(house);

    scene.suns.push_back({{0.0, -0.8, 0.6}, {60, 54, 44}});
    scene.sky = Sky{{4, 6, 10}, {9, 9.5, 10}, {2, 2, 1.8}};
    scene.symmetry = {{{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}}, {{span, 0.0, 0.0}, {-1.0, 0.0, 0.0}}};
    scene.periodic = {{0.0, bay, 0.0}};
    scene.camera = {{-0.1, -2.5, 2.0}, {0.2, 12.0, 1.6}, 60.0};
    return scene;
}

} // namespace scenes
