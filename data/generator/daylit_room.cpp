#include "scenes.h"

#include <array>
#include <cstdio>

namespace scenes {

namespace {

/// Test case 5.11 of CIE 171:2006, the smaller opening: a black room and a window in its wall y = 0.
constexpr double daylit_width = 4.0, daylit_depth = 4.0, daylit_height = 3.0;
constexpr std::array<double, 4> window{1.0, 3.0, 1.0, 2.0}; ///< x from, x to, z from, z to

void add_facade(Surface& room, unsigned material) {
    const std::array<double, 4> x{0.0, window[0], window[1], daylit_width}, z{0.0, window[2], window[3], daylit_height};
    for (std::size_t j = 0; j < 3; ++j) {
        for (std::size_t i = 0; i < 3; ++i) {
            if (i != 1 || j != 1) {
                room.polygon({{x[i], 0, z[j]}, {x[i], 0, z[j + 1]}, {x[i + 1], 0, z[j + 1]}, {x[i + 1], 0, z[j]}},
                             material);
            }
        }
    }
}

} // namespace

Surface daylit_room() {
    Surface room;
    room.remarks = {
        "Test case 5.11 of CIE 171:2006: a black room of 4 m by 4 m by 3 m with an unglazed window of 2 m by 1 m.",
        "Lengths are in metres, z is up. Made by data/generator/daylit_room.cpp.",
    };
    const unsigned black = room.add({"black", {0, 0, 0}, {}});
    const double w = daylit_width, d = daylit_depth, h = daylit_height;
    room.polygon({{0, 0, 0}, {w, 0, 0}, {w, d, 0}, {0, d, 0}}, black);
    room.polygon({{0, 0, h}, {0, d, h}, {w, d, h}, {w, 0, h}}, black);
    room.polygon({{0, d, 0}, {w, d, 0}, {w, d, h}, {0, d, h}}, black);
    room.polygon({{0, 0, 0}, {0, d, 0}, {0, d, h}, {0, 0, h}}, black);
    room.polygon({{w, 0, 0}, {w, 0, h}, {w, d, h}, {w, d, 0}}, black);
    add_facade(room, black);
    return room;
}

std::string daylit_room_json() {
    return R"({
  "difusa_scene": 1,
  "comment": "Test case 5.11 of CIE 171:2006 under the CIE standard overcast sky: 10000 lx on open ground, which reflects 30 %. Made by data/generator/daylit_room.cpp.",
  "unit": "m",
  "up": "z",
  "meshes": [{"file": "daylit_room.obj"}],
  "sky": {"type": "cie", "sky": "overcast", "illuminance": 10000, "ground_reflectance": 0.3}
}
)";
}

std::string daylit_room_points() {
    std::string text = "# The points of test case 5.11 of CIE 171:2006, 1 mm in front of the surface.\n"
                       "# Back wall, A to F; floor, G to N; ceiling, G' to N'.\nx,y,z,nx,ny,nz\n";
    char line[64];
    const double ahead = 0.001;
    for (int k = 0; k < 6; ++k) {
        std::snprintf(line, sizeof line, "2,%g,%g,0,-1,0\n", daylit_depth - ahead, 2.75 - 0.5 * k);
        text += line;
    }
    for (int k = 0; k < 8; ++k) {
        std::snprintf(line, sizeof line, "2,%g,%g,0,0,1\n", 3.75 - 0.5 * k, ahead);
        text += line;
    }
    for (int k = 0; k < 8; ++k) {
        std::snprintf(line, sizeof line, "2,%g,%g,0,0,-1\n", 3.75 - 0.5 * k, daylit_height - ahead);
        text += line;
    }
    return text;
}

} // namespace scenes
