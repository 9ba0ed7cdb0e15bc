#include "blocks.h"
#include "scenes.h"

namespace scenes {

Surface room() {
    Surface room;
    room.remarks = {
        "A furnished room lit through one large window by the sky.",
        "Lengths are in metres, z is up. Made up for this project by data/generator/room.cpp.",
        "Thin boards one over the other, table legs and a deep window reveal are what it is for.",
    };
    const unsigned plaster = room.add({"plaster", {0.80, 0.80, 0.78}, {}});
    const unsigned parquet = room.add({"parquet", {0.48, 0.32, 0.19}, {}});
    const unsigned red = room.add({"red", {0.62, 0.16, 0.12}, {}});
    const unsigned blue = room.add({"blue", {0.16, 0.28, 0.55}, {}});
    const unsigned wood = room.add({"wood", {0.60, 0.44, 0.28}, {}});

    const double length = 5.4, depth = 4.2, height = 2.7, wall = 0.3;
    Blocks blocks({-wall, -wall, -wall}, {length + wall, depth + wall, height + wall});
    blocks.fill({-wall, -wall, -wall}, {length + wall, depth + wall, height + wall}, plaster);
    blocks.fill({-wall, 0.0, 0.0}, {0.0, depth, height}, red);
    blocks.fill({length, 0.0, 0.0}, {length + wall, depth, height}, blue);
    blocks.fill({0.0, 0.0, -wall}, {length, depth, 0.0}, parquet);
    blocks.carve({0.0, 0.0, 0.0}, {length, depth, height});
    blocks.carve({1.2, -wall, 0.9}, {4.2, 0.0, 2.3}); // the window

    // A table.
    const double leg = 0.06, table_height = 0.74, board = 0.04;
    const Vector low{2.0, 1.5, 0.0}, high{3.6, 2.4, 0.0};
    blocks.fill({low.x, low.y, table_height - board}, {high.x, high.y, table_height}, wood);
    for (const double x : {low.x, high.x - leg}) {
        for (const double y : {low.y, high.y - leg}) {
            blocks.fill({x, y, 0.0}, {x + leg, y + leg, table_height - board}, wood);
        }
    }

    // A cupboard in the corner, and shelves on the red wall.
    blocks.fill({length - 0.6, depth - 1.4, 0.0}, {length, depth, 1.9}, wood);
    for (const double z : {1.0, 1.35, 1.7}) {
        blocks.fill({0.0, 1.5, z}, {0.3, 3.2, z + 0.03}, wood);
    }
    blocks.add_to(room);
    return room;
}

} // namespace scenes
