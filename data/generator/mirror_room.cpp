#include "blocks.h"
#include "scenes.h"

#include <cmath>

namespace scenes {

Scene mirror_room() {
    Scene scene;
    Surface& room = scene.surface;
    room.remarks = {
        "A room with a mirror on the wall, and one on a table that throws the sun onto the ceiling.",
        "Lengths are in metres, z is up. Made up for this project by data/generator/mirror_room.cpp.",
    };
    const unsigned plaster = room.add({"plaster", {0.75, 0.74, 0.70}, {}});
    const unsigned floor = room.add({"floor", {0.45, 0.30, 0.18}, {}});
    const unsigned green = room.add({"green", {0.25, 0.45, 0.25}, {}});
    const unsigned wood = room.add({"wood", {0.55, 0.38, 0.22}, {}});
    const unsigned mirror = room.add({"mirror", {0, 0, 0}, {}, {0.92, 0.94, 0.93}});

    const double length = 4.0, depth = 3.0, height = 2.5, wall = 0.2;
    Blocks blocks({-wall, -wall, -wall}, {length + wall, depth + wall, height + wall});
    blocks.fill({-wall, -wall, -wall}, {length + wall, depth + wall, height + wall}, plaster);
    blocks.fill({length, 0.0, 0.0}, {length + wall, depth, height}, green);
    blocks.fill({0.0, 0.0, -wall}, {length, depth, 0.0}, floor);
    blocks.carve({0.0, 0.0, 0.0}, {length, depth, height});
    blocks.carve({-wall, 0.9, 0.9}, {0.0, 2.1, 2.1}); // the window
    const double board = 0.7, top = 0.74;
    blocks.fill({0.6, 1.1, board}, {1.6, 2.1, top}, wood);
    for (const double x : {0.6, 1.54}) {
        for (const double y : {1.1, 2.04}) {
            blocks.fill({x, y, 0.0}, {x + 0.06, y + 0.06, board}, wood);
        }
    }
    // The mirrors, set into the wall and the table.
    blocks.leave_out({2.0, depth, 0.5}, {3.4, depth + wall, 2.0});
    blocks.leave_out({0.85, 1.45, board}, {1.15, 1.75, top});
    blocks.add_to(room);
    room.polygon({{2.0, depth, 0.5}, {3.4, depth, 0.5}, {3.4, depth, 2.0}, {2.0, depth, 2.0}}, mirror);
    room.polygon({{0.85, 1.45, top}, {1.15, 1.45, top}, {1.15, 1.75, top}, {0.85, 1.75, top}}, mirror);
    room.polygon({{0.85, 1.45, board}, {0.85, 1.75, board}, {1.15, 1.75, board}, {1.15, 1.45, board}}, wood);

    const double norm = std::sqrt(0.8 * 0.8 + 0.1 * 0.1 + 0.6 * 0.6);
    scene.suns.push_back({{-0.8 / norm, -0.1 / norm, 0.6 / norm}, {90, 84, 74}});
    scene.sky = Sky{{1.6, 2.2, 3.4}, {2.6, 2.8, 3.0}, {0.8, 0.8, 0.7}};
    scene.camera = {{0.25, 0.2, 1.45}, {2.9, 2.4, 1.35}, 74.0};
    return scene;
}

} // namespace scenes
