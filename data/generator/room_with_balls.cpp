#include "scenes.h"

#include <cmath>
#include <stdexcept>

namespace scenes {

Surface room_with_balls(std::size_t triangles) {
    if (triangles < 2000 || triangles > 50'000'000) {
        throw std::invalid_argument("room_with_balls: from 2000 to 50000000 triangles");
    }
    Surface room;
    room.remarks = {
        "A closed room of 6 x 5 x 3 m with walls in fine triangles, three balls, and a lamp under the ceiling.",
        "Lengths are in metres, z is up. Made by data/generator/room_with_balls.cpp, to measure speed in.",
    };
    const unsigned white = room.add({"white", {0.75, 0.75, 0.75}, {}});
    const unsigned red = room.add({"red", {0.60, 0.15, 0.12}, {}});
    const unsigned blue = room.add({"blue", {0.15, 0.25, 0.60}, {}});
    const unsigned floor = room.add({"floor", {0.45, 0.36, 0.27}, {}});
    const unsigned ball = room.add({"ball", {0.70, 0.65, 0.50}, {}});
    const unsigned lamp = room.add({"lamp", {0.80, 0.80, 0.80}, {60.0, 54.0, 44.0}});

    // At most half of the triangles go to the balls, the rest to the walls in squares of equal size. Rounding up gives
    // at least the rest: 2 triangles for each of two walls' ceil(a s) ceil(b s) squares, where s is squares per metre.
    // It adds less than 4 (28 s + 3), since 28 m of edges meet in a corner's three walls; s < 0.053 sqrt(triangles).
    const int lamp_triangles = 12;
    const auto ball_cells = static_cast<int>(std::sqrt(static_cast<double>(triangles) / 72.0));
    const double rest = static_cast<double>(triangles) - lamp_triangles - 36.0 * ball_cells * ball_cells;
    const double wall_area = 2.0 * (6.0 * 5.0 + 5.0 * 3.0 + 3.0 * 6.0);
    const double squares_a_metre = std::sqrt(rest / (2.0 * wall_area));
    const auto cells = [&](double metres) { return static_cast<int>(std::ceil(metres * squares_a_metre)); };
    add_box(room, {0.0, 0.0, 0.0}, {6.0, 5.0, 3.0}, {cells(6.0), cells(5.0), cells(3.0)},
            {red, blue, white, white, floor, white}, true);
    add_ball(room, {1.7, 1.6, 0.85}, 0.8, ball_cells, ball);
    add_ball(room, {4.2, 1.9, 0.65}, 0.6, ball_cells, ball);
    add_ball(room, {3.2, 3.6, 1.15}, 1.1, ball_cells, ball);
    add_box(room, {2.4, 2.1, 2.8}, {3.6, 2.9, 2.9}, {1, 1, 1}, {white, white, white, white, lamp, white}, false);
    return room;
}

} // namespace scenes
