#include "cornell_spectra.h"
#include "scenes.h"

#include <cmath>
#include <numbers>

namespace scenes {

namespace {

/// The published coordinates are in millimetres.
Vector millimetres(double x, double y, double z) {
    return {x / 1000.0, y / 1000.0, z / 1000.0};
}

using Corner = std::array<double, 2>;

/// A block without its bottom face: the four corners of its top in (x, z), clockwise seen from above.
void add_block(Surface& surface, const std::array<Corner, 4>& plan, double height, unsigned material) {
    const auto at = [&](std::size_t k, double y) { return millimetres(plan[k % 4][0], y, plan[k % 4][1]); };
    surface.polygon({at(0, height), at(1, height), at(2, height), at(3, height)}, material);
    for (std::size_t k = 0; k < 4; ++k) {
        surface.polygon({at(k, height), at(k, 0), at(k + 1, 0), at(k + 1, height)}, material);
    }
}

} // namespace

Scene cornell_box() {
    Scene scene;
    Surface& box = scene.surface;
    box.remarks = {
        "The Cornell box: a room open at the front with two blocks and a lamp in the ceiling.",
        "Lengths are in metres, y is up, and one looks in from -z. The coordinates are those measured and",
        "published by the Cornell University Program of Computer Graphics (\"Cornell Box Data\",",
        "www.graphics.cornell.edu/online/box/data.html), divided by 1000. Two things are made to fit here: the",
        "ceiling has a hole where the lamp is, and the red wall, whose four corners are not in one plane, is cut",
        "in two. Reflectances and emission are the published spectra in linear sRGB, where a constant spectrum of 1 is",
        "(1, 1, 1): means weighted with the sensitivities of the channels (the CIE 1931 matching functions in the fit "
        "of",
        "Wyman, Sloan and Shirley 2013, in light of equal energy). The emission has no unit in print; it is read as",
        "radiance, W/(m^2 sr), so Ke is pi times that. The lamp reflects 0.78 at every wavelength, as published.",
    };
    const CornellColours colours = cornell_colours();
    const unsigned white = box.add({"white", colours.white, {}});
    const unsigned red = box.add({"red", colours.red, {}});
    const unsigned green = box.add({"green", colours.green, {}});
    const Colour& radiance = colours.lamp;
    const unsigned lamp =
        box.add({"lamp",
                 {0.78, 0.78, 0.78},
                 {std::numbers::pi * radiance.r, std::numbers::pi * radiance.g, std::numbers::pi * radiance.b}});

    // Corners at the floor and the ceiling; low and high x in terms of the published names of the walls: red is at high
    // x, on the viewer's left.
    const Vector floor_red_front = millimetres(552.8, 0.0, 0.0), floor_green_front = millimetres(0.0, 0.0, 0.0),
                 floor_green_back = millimetres(0.0, 0.0, 559.2), floor_red_back = millimetres(549.6, 0.0, 559.2);
    const Vector top_red_front = millimetres(556.0, 548.8, 0.0), top_red_back = millimetres(556.0, 548.8, 559.2),
                 top_green_back = millimetres(0.0, 548.8, 559.2), top_green_front = millimetres(0.0, 548.8, 0.0);
    const std::array<Vector, 4> ceiling{top_red_front, top_red_back, top_green_back, top_green_front};
    const std::array<Vector, 4> light{millimetres(343.0, 548.8, 227.0), millimetres(343.0, 548.8, 332.0),
                                      millimetres(213.0, 548.8, 332.0), millimetres(213.0, 548.8, 227.0)};

    box.polygon({floor_red_front, floor_green_front, floor_green_back, floor_red_back}, white);
    box.polygon({light[0], light[1], light[2], light[3]}, lamp);
    for (std::size_t k = 0; k < 4; ++k) {
        const std::size_t next = (k + 1) % 4;
        box.polygon({ceiling[k], ceiling[next], light[next], light[k]}, white);
    }
    box.polygon({floor_red_back, floor_green_back, top_green_back, top_red_back}, white);
    box.polygon({floor_green_back, floor_green_front, top_green_front, top_green_back}, green);
    box.polygon({floor_red_front, floor_red_back, top_red_back}, red);
    box.polygon({floor_red_front, top_red_back, top_red_front}, red);
    add_block(box, {{{130.0, 65.0}, {82.0, 225.0}, {240.0, 272.0}, {290.0, 114.0}}}, 165.0, white);
    add_block(box, {{{423.0, 247.0}, {265.0, 296.0}, {314.0, 456.0}, {472.0, 406.0}}}, 330.0, white);

    // The published camera: 25 mm of film, lens 35 mm in front of it.
    scene.up = 'y';
    const Vector eye = millimetres(278.0, 273.0, -800.0);
    scene.camera = {eye, {eye.x, eye.y, 0.0}, 2.0 * std::atan(0.0125 / 0.035) * 180.0 / std::numbers::pi};
    return scene;
}

} // namespace scenes
