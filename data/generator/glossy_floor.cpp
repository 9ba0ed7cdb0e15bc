#include "scenes.h"

namespace scenes {

Scene glossy_floor() {
    Scene scene;
    Surface& room = scene.surface;
    room.remarks = {
        "A room with a polished floor, in which a lamp, a red wall, two blocks and a ball are seen blurred.",
        "Lengths are in metres, z is up. Made up for this project by data/generator/glossy_floor.cpp.",
    };
    const unsigned plaster = room.add({"plaster", {0.72, 0.71, 0.68}, {}});
    const unsigned red = room.add({"red", {0.60, 0.12, 0.08}, {}});
    const unsigned blue = room.add({"blue", {0.10, 0.18, 0.50}, {}});
    const unsigned yellow = room.add({"yellow", {0.65, 0.50, 0.10}, {}});
    const unsigned lamp = room.add({"lamp", {0, 0, 0}, {55, 52, 46}});
    Material polished{"polished", {0.08, 0.05, 0.03}, {}, {0.45, 0.45, 0.45}};
    polished.exponent = 150.0;
    const unsigned floor = room.add(polished);

    const double length = 5.0, depth = 4.0, height = 2.7;
    room.polygon({{0, 0, 0}, {length, 0, 0}, {length, depth, 0}, {0, depth, 0}}, floor);
    room.polygon({{0, 0, height}, {0, depth, height}, {length, depth, height}, {length, 0, height}}, plaster);
    room.polygon({{0, 0, 0}, {0, 0, height}, {length, 0, height}, {length, 0, 0}}, plaster);
    room.polygon({{0, depth, 0}, {length, depth, 0}, {length, depth, height}, {0, depth, height}}, plaster);
    room.polygon({{0, 0, 0}, {0, depth, 0}, {0, depth, height}, {0, 0, height}}, plaster);
    room.polygon({{length, 0, 0}, {length, 0, height}, {length, depth, height}, {length, depth, 0}}, red);
    const double proud = 0.01; // the lamp, before the wall
    room.polygon(
        {{1.6, depth - proud, 1.5}, {2.6, depth - proud, 1.5}, {2.6, depth - proud, 1.8}, {1.6, depth - proud, 1.8}},
        lamp);
    const std::array<unsigned, 6> all_blue{blue, blue, blue, blue, blue, blue};
    const std::array<unsigned, 6> all_yellow{yellow, yellow, yellow, yellow, yellow, yellow};
    add_box(room, {3.4, 2.6, 0.0}, {4.0, 3.2, 1.1}, {2, 2, 3}, all_blue, false);
    add_box(room, {0.7, 2.4, 0.0}, {1.2, 2.9, 0.5}, {2, 2, 2}, all_yellow, false);
    add_ball(room, {2.5, 2.0, 0.35}, 0.35, 8, plaster);
    scene.camera = {{2.4, 0.15, 1.55}, {2.5, 3.2, 0.55}, 62.0};
    return scene;
}

} // namespace scenes
