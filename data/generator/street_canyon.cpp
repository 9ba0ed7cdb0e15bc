#include "blocks.h"
#include "scenes.h"

namespace scenes {

Scene street_canyon() {
    Scene scene;
    Surface& street = scene.surface;
    street.remarks = {
        "One period of a town of parallel streets: two houses on either side, with an arcade along one of them.",
        "The town goes on in both directions: the period ends in the middle of lanes and back yards.",
        "Lengths are in metres, z is up. Made up for this project by data/generator/street_canyon.cpp.",
    };
    const unsigned asphalt = street.add({"asphalt", {0.12, 0.12, 0.13}, {}});
    const unsigned pavement = street.add({"pavement", {0.38, 0.36, 0.33}, {}});
    const unsigned plaster = street.add({"plaster", {0.68, 0.62, 0.50}, {}});
    const unsigned brick = street.add({"brick", {0.50, 0.24, 0.16}, {}});
    const unsigned white = street.add({"white", {0.80, 0.79, 0.76}, {}});
    const unsigned roof = street.add({"roof", {0.30, 0.28, 0.27}, {}});

    const double width = 26.0, length = 20.0, yard = 1.5, lane = 1.0, middle = 12.0;
    const double west = 7.0, east = 19.0; // fronts of the houses
    Blocks blocks({0.0, 0.0, -1.0}, {width, length, 20.0});
    blocks.fill({0.0, 0.0, -1.0}, {width, length, 0.0}, asphalt);
    blocks.fill({west, 0.0, 0.0}, {west + 2.5, length, 0.15}, pavement);
    blocks.fill({east - 2.5, 0.0, 0.0}, {east, length, 0.15}, pavement);
    const auto house = [&](double x0, double x1, double y0, double y1, double height, unsigned material) {
        blocks.fill({x0, y0, 0.0}, {x1, y1, height}, material);
        blocks.fill({x0, y0, height}, {x1, y1, height + 0.3}, roof);
    };
    house(yard, west, lane, middle, 10.0, plaster);
    house(yard, west, middle, length - lane, 13.0, brick);
    house(east, width - yard, lane, middle, 13.0, white);
    house(east, width - yard, middle, length - lane, 8.5, plaster);
    // The arcade of the white house, and a balcony opposite.
    blocks.carve({east, lane, 0.15}, {east + 2.5, middle - 1.0, 4.0});
    blocks.fill({east, lane, 0.0}, {east + 2.5, middle - 1.0, 0.15}, pavement);
    for (const double y : {lane, 4.2, 7.4}) {
        blocks.fill({east, y, 0.15}, {east + 0.5, y + 0.5, 4.0}, white);
    }
    blocks.fill({west, 3.0, 6.0}, {west + 1.2, 8.0, 6.2}, white);
    blocks.fill({west + 1.1, 3.0, 6.2}, {west + 1.2, 8.0, 7.0}, white);
    blocks.add_to(street);

    scene.suns.push_back({{0.48, -0.6, 0.64}, {95, 88, 76}});
    scene.sky = Sky{{5, 7, 11}, {8, 8.5, 9}, {2, 2, 1.8}};
    scene.periodic = {{width, 0.0, 0.0}, {0.0, length, 0.0}};
    scene.camera = {{10.6, -6.0, 1.8}, {13.6, 20.0, 4.6}, 55.0};
    return scene;
}

} // namespace scenes
