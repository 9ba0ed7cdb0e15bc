#include "blocks.h"
#include "scenes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace scenes {

namespace {

/// A horizontal ring of a column: its largest radius, and how much smaller it is in the middle of a flute.
struct Ring {
    double z, radius, flute;
};

constexpr int flutes = 20, points_per_flute = 6;

/// From the plinth to the abacus, z from 0 to 3.7: two tori with a hollow between them, the shaft, a neck and the
/// echinus.
std::vector<Ring> column_profile() {
    std::vector<Ring> rings;
    // Adds `steps` rings up to z; radius and flute as functions of the fraction t of the way.
    const auto rise = [&](double z, int steps, const auto& radius, const auto& flute) {
        const double low = rings.empty() ? 0.0 : rings.back().z;
        for (int i = rings.empty() ? 0 : 1; i <= steps; ++i) {
            const double t = static_cast<double>(i) / steps;
            rings.push_back({low + (z - low) * t, radius(t), flute(t)});
        }
    };
    const auto straight = [](double from, double to) { return [=](double t) { return from + (to - from) * t; }; };
    const auto bulge = [](double radius, double by) {
        return [=](double t) { return radius + by * std::sin(std::numbers::pi * t); };
    };
    const auto plain = [](double) { return 0.0; };
    rise(0.12, 12, bulge(0.36, 0.07), plain);
    rise(0.15, 1, straight(0.36, 0.34), plain);
    rise(0.25, 8, bulge(0.34, -0.03), plain);
    rise(0.33, 10, bulge(0.34, 0.035), plain);
    rise(0.36, 1, straight(0.34, 0.32), plain);
    rise(
        3.14, 24, [](double t) { return 0.32 - 0.05 * std::pow(t, 1.6); },
        [](double t) { return 0.02 * std::sin(std::numbers::pi / 2.0 * std::min(1.0, std::min(t, 1.0 - t) / 0.08)); });
    rise(3.22, 8, bulge(0.27, 0.025), plain);
    rise(3.40, 2, straight(0.27, 0.27), plain);
    rise(
        3.64, 14, [](double t) { return 0.42 - 0.15 * std::cos(std::numbers::pi / 2.0 * t); }, plain);
    rise(3.70, 2, straight(0.42, 0.42), plain);
    return rings;
}

/// A column in a box with a square plan, standing on and supporting a solid: it closes the squares at its ends.
void add_column(Surface& surface, const Vector& low, const Vector& high, unsigned material) {
    const Vector a = rounded(low), b = rounded(high);
    const Vector middle{0.5 * (a.x + b.x), 0.5 * (a.y + b.y), 0.0};
    const int around = flutes * points_per_flute;
    const std::vector<Ring> rings = column_profile();
    const auto at = [&](std::size_t ring, int i) -> Vector {
        const Ring& r = rings[ring];
        const double turn = static_cast<double>(i % around) / around;
        const double radius = r.radius - r.flute * std::abs(std::sin(std::numbers::pi * flutes * turn));
        const double angle = 2.0 * std::numbers::pi * turn;
        return {middle.x + radius * std::cos(angle), middle.y + radius * std::sin(angle),
                ring + 1 == rings.size() ? b.z : a.z + r.z};
    };
    for (std::size_t ring = 0; ring + 1 < rings.size(); ++ring) {
        for (int i = 0; i < around; ++i) {
            surface.polygon({at(ring, i), at(ring, i + 1), at(ring + 1, i + 1)}, material);
            surface.polygon({at(ring, i), at(ring + 1, i + 1), at(ring + 1, i)}, material);
        }
    }
    for (const bool top : {false, true}) {
        const std::size_t ring = top ? rings.size() - 1 : 0;
        // Counterclockwise seen from above; reversed under the abacus.
        const auto triangle = [&](const Vector& p, const Vector& q, const Vector& r) {
            surface.polygon(top ? std::vector<Vector>{p, r, q} : std::vector<Vector>{p, q, r}, material);
        };
        const double z = top ? b.z : a.z;
        const std::array<Vector, 4> corners{{{b.x, b.y, z}, {a.x, b.y, z}, {a.x, a.y, z}, {b.x, a.y, z}}};
        for (int quarter = 0; quarter < 4; ++quarter) {
            const Vector &corner = corners[static_cast<std::size_t>(quarter)],
                         &next = corners[static_cast<std::size_t>((quarter + 1) % 4)];
            const int first = quarter * around / 4, end = (quarter + 1) * around / 4;
            for (int i = first; i < end; ++i) {
                triangle(at(ring, i), corner, at(ring, i + 1));
            }
            triangle(at(ring, end), corner, next);
        }
    }
}

} // namespace

Scene hall() {
    Scene scene;
    Surface& surface = scene.surface;
    surface.remarks = {
        "A colonnaded hall: a sunken nave with a coffered ceiling between two arcades on fluted columns, aisles behind",
        "them, and clerestory windows with round heads, through which the sun shines.",
        "Lengths are in metres, z is up. Made up for this project by data/generator/hall.cpp.",
    };
    const unsigned plaster = surface.add({"plaster", {0.78, 0.75, 0.68}, {}});
    const unsigned stone = surface.add({"stone", {0.66, 0.62, 0.55}, {}});
    const unsigned marble = surface.add({"marble", {0.74, 0.72, 0.69}, {}});
    const unsigned slate = surface.add({"slate", {0.20, 0.21, 0.23}, {}});
    const unsigned terracotta = surface.add({"terracotta", {0.58, 0.25, 0.15}, {}});
    const unsigned wood = surface.add({"wood", {0.42, 0.27, 0.15}, {}});

    const int bays = 9;
    const double bay = 4.0, half = 0.45, length = bays * bay; // half: of a column's plinth and of the wall over it
    const double aisle = 3.5, nave = 8.0, wall = 2.0 * half, depth = 2.0 * (aisle + wall) + nave;
    const double south = aisle, north = aisle + wall + nave; // start of the arcades
    const double plinth = 0.3, abacus = 4.0, spring = 4.2, crown = 6.1, aisle_ceiling = 6.4, roof = 6.6;
    const double sill = 7.4, window_spring = 8.1, window_top = 10.0, beam = 10.2, ceiling = 10.6;

    const double shell = 0.4, bottom = -1.0;
    Blocks blocks({-shell, -shell, bottom}, {length + shell, depth + shell, ceiling + shell});
    blocks.fill({-shell, -shell, bottom}, {length + shell, depth + shell, ceiling + shell}, plaster);
    blocks.fill({0.0, 0.0, bottom}, {length, depth, 0.0}, slate);
    for (const double y : {0.0, depth - aisle}) {
        blocks.carve({0.0, y, 0.0}, {length, y + aisle, aisle_ceiling});
    }
    blocks.carve({0.0, south + wall, 0.0}, {length, north, ceiling});
    blocks.leave_out({-shell, -shell, roof}, {length + shell, south, ceiling + shell}); // outdoors, over the aisles
    blocks.leave_out({-shell, north + wall, roof}, {length + shell, depth + shell, ceiling + shell});

    // The nave is three steps down.
    const double tread = 0.35, riser = 0.15, sunk = 3.0 * riser;
    blocks.carve({0.0, south + wall, -sunk}, {length, north, 0.0});
    for (int step = 1; step <= 2; ++step) {
        blocks.fill({0.0, south + wall + (step - 1) * tread, -sunk},
                    {length, south + wall + step * tread, -step * riser}, stone);
        blocks.fill({0.0, north - step * tread, -sunk}, {length, north - (step - 1) * tread, -step * riser}, stone);
    }

    for (int k = 0; k < bays; ++k) {
        const double x_low = k * bay + half, x_high = (k + 1) * bay - half;
        for (const double y : {south, north}) {
            blocks.carve({x_low, y, 0.0}, {x_high, y + wall, spring});
            blocks.arch({x_low, y, spring}, {x_high, y + wall, crown}, 24, plaster);
            blocks.carve({x_low, y, sill}, {x_high, y + wall, window_spring});
            blocks.arch({x_low, y, window_spring}, {x_high, y + wall, window_top}, 24, plaster);
        }
        // Pavement of slate bands, and between them slabs in two colours.
        for (const double y : {0.0, depth - aisle}) {
            blocks.fill({x_low, y, bottom}, {x_high, y + aisle, 0.0}, terracotta);
        }
        const int slabs = 6;
        const double first = south + wall + 2.0 * tread, slab = (nave - 4.0 * tread) / slabs;
        for (int j = 0; j < slabs; ++j) {
            blocks.fill({x_low, first + j * slab, bottom}, {x_high, first + (j + 1) * slab, -sunk},
                        (j + k) % 2 == 0 ? marble : terracotta);
        }
    }

    // Beams along the nave and across it.
    for (const double y : {south + wall + 2.3, north - 2.8}) {
        blocks.fill({0.0, y, beam}, {length, y + 0.5, ceiling}, wood);
    }
    for (int k = 1; k < bays; ++k) {
        const double x_low = k * bay - half, x_high = k * bay + half;
        blocks.fill({x_low, south + wall, beam}, {x_high, north, ceiling}, wood);
        for (const double y : {south, north}) {
            blocks.fill({x_low, y, 0.0}, {x_high, y + wall, plinth}, stone);
            blocks.leave_out({x_low, y, plinth}, {x_high, y + wall, abacus});
            blocks.fill({x_low, y, abacus}, {x_high, y + wall, spring}, stone);
            add_column(surface, {x_low, y, plinth}, {x_high, y + wall, abacus}, marble);
        }
    }
    blocks.add_to(surface);

    scene.suns.push_back({{-0.30, -0.55, 0.75}, {720.0, 670.0, 560.0}});
    scene.sky = Sky{{14.0, 22.0, 36.0}, {30.0, 33.0, 36.0}, {12.0, 11.0, 9.0}};
    scene.camera = {{1.2, 7.6, 1.5}, {30.0, 8.9, 4.2}, 58.0};
    return scene;
}

} // namespace scenes
