#include "blocks.h"
#include "scenes.h"

#include <cmath>
#include <numbers>
#include <string>
#include <utility>

namespace scenes {

namespace {

/// A room whose inside spans from the origin to `size`, x to the right and y away from the viewer. Walls are sheets
/// facing inwards, but show the thickness `wall` at windows.
class Room {
  public:
    Room(const std::string& title, const Vector& size, double wall)
        : size_(size), wall_(wall), blocks_({-wall, -wall, -wall}, {size.x + wall, size.y + wall, size.z + wall}) {
        scene.surface.remarks = {
            title + " of the dissertation's chapter 6. Made by data/generator/dissertation_rooms.cpp.",
            "z is up. Lengths are the dissertation's units, taken for metres, so that light counts in W and W/m^2.",
            "What the text does not say is chosen: all colours but the red ball's, depths, places, and the strength of",
            "the light. It places as many sites as it tells of at half of the spacing that it tells of.",
        };
    }

    unsigned material(const std::string& name, const Colour& reflectance) {
        return scene.surface.add({name, reflectance, {}});
    }

    /// The bare room, before objects and windows are added.
    void build(unsigned walls, unsigned left, unsigned right, unsigned floor) {
        blocks_.fill({-wall_, -wall_, -wall_}, {size_.x + wall_, size_.y + wall_, size_.z + wall_}, walls);
        blocks_.fill({-wall_, 0.0, 0.0}, {0.0, size_.y, size_.z}, left);
        blocks_.fill({size_.x, 0.0, 0.0}, {size_.x + wall_, size_.y, size_.z}, right);
        blocks_.fill({0.0, 0.0, -wall_}, {size_.x, size_.y, 0.0}, floor);
        blocks_.carve({0.0, 0.0, 0.0}, size_);
    }

    void window_left(double y_low, double y_high, double z_low, double z_high) {
        blocks_.carve({-wall_, y_low, z_low}, {0.0, y_high, z_high});
    }

    /// A pane of a window in the back wall.
    void pane_back(double x_low, double x_high, double z_low, double z_high) {
        blocks_.carve({x_low, size_.y, z_low}, {x_high, size_.y + wall_, z_high});
    }

    void cube(double x_low, double y_low, double side, unsigned material) {
        blocks_.fill({x_low, y_low, 0.0}, {x_low + side, y_low + side, side}, material);
    }

    /// A ball resting at a height. It has an odd number of cells, so that a face is lowest and does not quite touch.
    void ball(double x, double y, double resting, double radius, unsigned material) {
        add_ball(scene.surface, {x, y, resting + radius}, radius, radius > 12.0 ? 17 : 11, material);
    }

    Scene finish() {
        blocks_.add_to(scene.surface);
        return std::move(scene);
    }

    Scene scene;

  private:
    Vector size_;
    double wall_;
    Blocks blocks_;
};

const Colour white{0.78, 0.77, 0.74}, boards{0.52, 0.38, 0.25}, red{0.66, 0.13, 0.10}, blue{0.20, 0.32, 0.60},
    green{0.25, 0.52, 0.26}, yellow{0.76, 0.62, 0.22};

} // namespace

Scene room_a() {
    Room room("Room A", {160.0, 137.0, 80.0}, 6.0);
    const unsigned walls = room.material("walls", white), right = room.material("right", blue),
                   floor = room.material("floor", boards), ball = room.material("ball", red);
    room.build(walls, walls, right, floor);
    room.window_left(44.0, 104.0, 28.0, 66.0);
    room.ball(70.0, 62.0, 0.0, 20.0, ball);

    const double elevation = 40.0 * std::numbers::pi / 180.0, aside = 20.0 * std::numbers::pi / 180.0;
    room.scene.suns.push_back(
        {{-std::cos(elevation) * std::cos(aside), std::cos(elevation) * std::sin(aside), std::sin(elevation)},
         {100.0, 94.0, 82.0}});
    room.scene.camera = {{154.0, 4.0, 54.0}, {56.0, 100.0, 28.0}, 66.0};
    return room.finish();
}

Scene room_b() {
    Room room("Room B", {80.0, 80.0, 80.0}, 4.0);
    const unsigned walls = room.material("walls", white), left = room.material("left", red),
                   right = room.material("right", green), floor = room.material("floor", boards),
                   cubes = room.material("cubes", white), balls = room.material("balls", yellow),
                   small = room.material("small_ball", blue);
    room.build(walls, left, right, floor);
    room.cube(48.0, 46.0, 22.0, cubes);
    room.cube(8.0, 20.0, 16.0, cubes);
    room.ball(24.0, 58.0, 0.0, 16.0, balls);
    room.ball(59.0, 57.0, 22.0, 10.0, small);
    room.ball(62.0, 28.0, 0.0, 10.0, balls);

    room.scene.points.push_back({{40.0, 70.0, 76.0}, {3000.0, 2800.0, 2400.0}});
    room.scene.camera = {{40.0, 0.5, 42.0}, {40.0, 80.0, 32.0}, 78.0};
    return room.finish();
}

Scene room_c() {
    Room room("Room C", {160.0, 130.0, 80.0}, 6.0);
    const unsigned walls = room.material("walls", white), right = room.material("right", green),
                   floor = room.material("floor", boards), ball = room.material("ball", red),
                   cube = room.material("cube", blue);
    room.build(walls, walls, right, floor);
    room.window_left(17.0, 49.0, 28.0, 64.0);
    room.window_left(81.0, 113.0, 28.0, 64.0);
    room.ball(58.0, 34.0, 0.0, 16.0, ball);
    room.cube(66.0, 90.0, 28.0, cube);

    room.scene.points.push_back({{-40.0, 65.0, 84.0}, {200000.0, 190000.0, 170000.0}});
    room.scene.camera = {{154.0, 4.0, 54.0}, {54.0, 96.0, 28.0}, 66.0};
    return room.finish();
}

Scene room_d() {
    Room room("Room D", {120.0, 160.0, 90.0}, 5.0);
    const unsigned walls = room.material("walls", white), left = room.material("left", yellow),
                   right = room.material("right", blue), floor = room.material("floor", boards),
                   cubes = room.material("cubes", red);
    room.build(walls, left, right, floor);
    // Four windows of 2 x 4 panes with bars between them.
    const double pane = 9.0, bar = 2.0, gap = 8.0;
    for (int window = 0; window < 4; ++window) {
        for (int column = 0; column < 2; ++column) {
            for (int row = 0; row < 4; ++row) {
                const double x = gap + window * (2.0 * pane + bar + gap) + column * (pane + bar);
                const double z = 30.0 + row * (pane + bar);
                room.pane_back(x, x + pane, z, z + pane);
            }
        }
    }
    room.cube(20.0, 88.0, 26.0, cubes);
    room.cube(74.0, 62.0, 26.0, cubes);

    room.scene.points.push_back({{60.0, 250.0, 120.0}, {600000.0, 570000.0, 510000.0}});
    room.scene.camera = {{60.0, 1.0, 52.0}, {60.0, 160.0, 36.0}, 60.0};
    return room.finish();
}

} // namespace scenes
