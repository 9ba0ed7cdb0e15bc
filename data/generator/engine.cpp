#include "scenes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace scenes {

namespace {

Vector operator+(const Vector& a, const Vector& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}

Vector operator-(const Vector& a, const Vector& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}

Vector operator*(double s, const Vector& v) {
    return {s * v.x, s * v.y, s * v.z};
}

Vector cross(const Vector& a, const Vector& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

Vector unit(const Vector& v) {
    return 1.0 / std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z) * v;
}

/// Two unit vectors that form a right-handed frame with the unit vector `axis`.
std::pair<Vector, Vector> across(const Vector& axis) {
    const Vector u = unit(cross(std::abs(axis.z) < 0.9 ? Vector{0, 0, 1} : Vector{1, 0, 0}, axis));
    return {u, cross(axis, u)};
}

/// A corner of the profile of a solid of revolution.
struct Turn {
    double radius, height;
};

/// Parts as an exporter writes them: each a separate closed surface, regardless of what it touches or penetrates.
class Parts {
  public:
    Parts(Surface& surface, int segments) : surface_(surface), segments_(segments) {}

    void box(const Vector& low, const Vector& high, unsigned material) {
        add_box(surface_, low, high, {1, 1, 1}, {material, material, material, material, material, material}, false);
    }

    /// The profile runs along the outside from the axis below to the axis above; `around` corners, by default as
    /// appropriate for a part of this accuracy.
    void lathe(const Vector& foot, const Vector& axis, const std::vector<Turn>& profile, unsigned material,
               int around = 0) {
        const int n = around > 0 ? around : segments_;
        const Vector along = unit(axis);
        const auto [u, v] = across(along);
        const auto at = [&, u = u, v = v](const Turn& turn, int i) {
            const double angle = 2.0 * std::numbers::pi * (i % n) / n;
            return foot + turn.height * along + turn.radius * (std::cos(angle) * u + std::sin(angle) * v);
        };
        for (std::size_t k = 0; k + 1 < profile.size(); ++k) {
            const Turn &low = profile[k], &high = profile[k + 1];
            for (int i = 0; i < n; ++i) {
                if (low.radius > 0.0) {
                    surface_.polygon({at(low, i), at(low, i + 1), at(high, i)}, material);
                }
                if (high.radius > 0.0) {
                    surface_.polygon({at(low, i + 1), at(high, i + 1), at(high, i)}, material);
                }
            }
        }
    }

    void cylinder(const Vector& foot, const Vector& axis, double radius, double height, unsigned material) {
        lathe(foot, axis, {{0.0, 0.0}, {radius, 0.0}, {radius, height}, {0.0, height}}, material);
    }

    /// A hexagon bolt of nominal size `size` with its washer; its shank penetrates the plate below `foot`.
    void bolt(const Vector& foot, const Vector& axis, double size, unsigned material) {
        const Vector along = unit(axis);
        cylinder(foot, along, 1.1 * size, 0.2 * size, material);
        const Vector seat = foot + 0.2 * size * along;
        lathe(seat, along,
              {{0.0, 0.0}, {0.9 * size, 0.0}, {0.9 * size, 0.55 * size}, {0.8 * size, 0.65 * size}, {0.0, 0.65 * size}},
              material, 6);
        cylinder(foot - 1.5 * size * along, along, 0.5 * size, 2.6 * size, material);
    }

    /// Bolts on a circle around an axis.
    void bolt_circle(const Vector& centre, const Vector& axis, double radius, int count, double size,
                     unsigned material) {
        const auto [u, v] = across(unit(axis));
        for (int i = 0; i < count; ++i) {
            const double angle = 2.0 * std::numbers::pi * (i + 0.5) / count;
            bolt(centre + radius * (std::cos(angle) * u + std::sin(angle) * v), axis, size, material);
        }
    }

    /// A pipe through the corners of a path with right-angled turns, with bends of radius `bend`.
    void pipe(const std::vector<Vector>& path, double radius, double bend, unsigned material) {
        const int steps = std::max(2, segments_ / 4);
        std::vector<Vector> centre{path.front()}, along{unit(path[1] - path[0])};
        for (std::size_t k = 1; k + 1 < path.size(); ++k) {
            const Vector in = unit(path[k] - path[k - 1]), out = unit(path[k + 1] - path[k]);
            const Vector hub = path[k] - bend * in + bend * out;
            for (int i = 0; i <= steps; ++i) {
                const double angle = 0.5 * std::numbers::pi * i / steps;
                centre.push_back(hub + bend * (std::sin(angle) * in - std::cos(angle) * out));
                along.push_back(std::cos(angle) * in + std::sin(angle) * out);
            }
        }
        centre.push_back(path.back());
        along.push_back(unit(path.back() - path[path.size() - 2]));
        // Each frame is the previous one, rotated minimally: the bends are planar, so one axis is enough.
        std::vector<std::array<Vector, 2>> frame;
        auto [u, v] = across(along.front());
        for (const Vector& direction : along) {
            u = unit(cross(v, direction));
            v = cross(direction, u);
            frame.push_back({u, v});
        }
        const auto at = [&](std::size_t k, int i) {
            const double angle = 2.0 * std::numbers::pi * (i % segments_) / segments_;
            return centre[k] + radius * (std::cos(angle) * frame[k][0] + std::sin(angle) * frame[k][1]);
        };
        for (std::size_t k = 0; k + 1 < centre.size(); ++k) {
            for (int i = 0; i < segments_; ++i) {
                surface_.polygon({at(k, i), at(k, i + 1), at(k + 1, i)}, material);
                surface_.polygon({at(k, i + 1), at(k + 1, i + 1), at(k + 1, i)}, material);
            }
        }
        for (int i = 0; i < segments_; ++i) {
            surface_.polygon({centre.front(), at(0, i + 1), at(0, i)}, material);
            surface_.polygon({centre.back(), at(centre.size() - 1, i), at(centre.size() - 1, i + 1)}, material);
        }
    }

  private:
    Surface& surface_;
    int segments_;
};

struct Paints {
    unsigned iron, alloy, steel, copper, floor;
};

/// One cylinder with its head, fins, flanges and pipes; `top` is the middle of its foot on the block.
void add_cylinder(Parts& parts, const Vector& top, int number, const Paints& paint) {
    const Vector up{0, 0, 1};
    parts.lathe(top, up, {{0, 0}, {0.085, 0}, {0.085, 0.015}, {0.062, 0.015}, {0.062, 0.2}, {0, 0.2}}, paint.alloy);
    parts.bolt_circle(top + Vector{0, 0, 0.015}, up, 0.0735, 12, 0.005, paint.steel);
    for (int fin = 0; fin < 12; ++fin) { // discs through the barrel
        const double z = 0.03 + 0.013 * fin;
        parts.lathe(top, up, {{0, z}, {0.08, z}, {0.081, z + 0.0015}, {0.08, z + 0.003}, {0, z + 0.003}}, paint.alloy);
    }
    const Vector head = top + Vector{0, 0, 0.2};
    parts.lathe(head, up, {{0, 0}, {0.083, 0}, {0.083, 0.03}, {0.06, 0.05}, {0, 0.05}}, paint.iron);
    parts.bolt_circle(head + Vector{0, 0, 0.03}, up, 0.079, 8, 0.0035, paint.steel);
    parts.lathe(head + Vector{0, 0, 0.04}, {0.3, 0, 1},
                {{0, 0}, {0.012, 0}, {0.012, 0.02}, {0.009, 0.025}, {0.009, 0.05}, {0.004, 0.055}, {0, 0.055}},
                paint.steel); // spark plug
    for (const double side : {-1.0, 1.0}) {
        const Vector out{0, side, 0};
        const Vector port = head + Vector{0, side * 0.07, 0.015};
        parts.lathe(port, out, {{0, 0}, {0.024, 0}, {0.024, 0.03}, {0, 0.03}}, paint.iron);
        parts.lathe(port + 0.028 * out, out, {{0, 0}, {0.034, 0}, {0.034, 0.006}, {0, 0.006}}, paint.iron);
        parts.bolt_circle(port + 0.034 * out, out, 0.029, 6, 0.003, paint.steel);
        // Down into the manifold, which lies along the block.
        parts.pipe({port + 0.02 * out, port + 0.12 * out, port + 0.12 * out - 0.26 * up}, 0.018, 0.04,
                   side < 0.0 ? paint.iron : paint.copper);
        // An oil line across all of it.
        const double z = 0.012 * (number % 3);
        parts.pipe({top + Vector{0.03, side * 0.05, -0.02}, top + Vector{0.03, side * 0.05, 0.017 + z},
                    top + Vector{0.03, side * 0.16, 0.017 + z}, top + Vector{0.03, side * 0.16, -0.16}},
                   0.004, 0.008, paint.copper);
    }
}

Scene engine_of(int segments) {
    Scene scene;
    Surface& surface = scene.surface;
    surface.remarks = {
        "An engine of many small parts, as a CAD program exports an assembly: closed parts that stand on each other "
        "and",
        "stick in each other, none cut where another begins.",
        "Lengths are in metres, z is up. Made up for this project by data/generator/engine.cpp.",
    };
    Paints paint{};
    paint.iron = surface.add({"iron", {0.32, 0.33, 0.35}, {}});
    paint.alloy = surface.add({"alloy", {0.72, 0.72, 0.70}, {}});
    paint.steel = surface.add({"steel", {0.56, 0.57, 0.58}, {}});
    paint.copper = surface.add({"copper", {0.72, 0.42, 0.28}, {}});
    paint.floor = surface.add({"floor", {0.62, 0.60, 0.55}, {}});

    Parts parts(surface, segments);
    const int cylinders = 8;
    const double pitch = 0.2, length = cylinders * pitch, half = 0.13, block_top = 0.4;
    parts.box({-1.0, -1.2, -0.05}, {length + 1.0, 1.2, 0.0}, paint.floor);
    for (const double x : {0.1, length - 0.2}) { // the cradle
        parts.box({x, -0.4, 0.0}, {x + 0.1, 0.4, 0.08}, paint.steel);
        for (const double y : {-0.36, -0.3, 0.3, 0.36}) {
            parts.bolt({x + 0.05, y, 0.08}, {0, 0, 1}, 0.012, paint.steel);
        }
    }
    parts.box({0.0, -half, 0.05}, {length, half, block_top}, paint.iron);
    parts.box({-0.02, -half - 0.03, 0.2}, {length + 0.02, half + 0.03, 0.215}, paint.iron); // a flange all around
    const int bolts = 40;
    for (int i = 0; i < bolts; ++i) {
        const double x = length * (i + 0.5) / bolts;
        for (const double side : {-1.0, 1.0}) {
            parts.bolt({x, side * (half + 0.016), 0.215}, {0, 0, 1}, 0.006, paint.steel);
            parts.box({x - 0.002, side * half - 0.025, 0.1}, {x + 0.002, side * half + 0.025, 0.3}, paint.iron); // rib
        }
    }
    for (const double side : {-1.0, 1.0}) { // manifolds
        parts.cylinder({-0.05, side * 0.22, 0.33}, {1, 0, 0}, 0.035, length + 0.1, paint.iron);
        for (int i = 0; i < 4; ++i) {
            parts.box({0.2 + 0.4 * i, side * 0.17 - 0.06, 0.325}, {0.21 + 0.4 * i, side * 0.17 + 0.06, 0.335},
                      paint.steel);
        }
    }
    for (const double end : {0.0, length}) { // covers of the crankshaft, and its flywheel and pulley
        const Vector out{end > 0.0 ? 1.0 : -1.0, 0, 0};
        const Vector hub{end, 0, 0.21};
        parts.lathe(hub, out, {{0, -0.01}, {0.115, -0.01}, {0.115, 0.02}, {0.1, 0.03}, {0, 0.03}}, paint.alloy);
        parts.bolt_circle(hub + 0.03 * out, out, 0.09, 16, 0.005, paint.steel);
        parts.cylinder(hub, out, 0.03, 0.2, paint.steel);
        const double wheel = end > 0.0 ? 0.2 : 0.12;
        parts.lathe(hub, out, {{0, 0.08}, {wheel, 0.08}, {wheel, 0.1}, {wheel - 0.02, 0.12}, {0, 0.12}}, paint.steel);
        parts.bolt_circle(hub + 0.12 * out, out, 0.05, 8, 0.008, paint.steel);
    }
    for (int i = 0; i < cylinders; ++i) {
        add_cylinder(parts, {pitch * (i + 0.5), 0, block_top}, i, paint);
    }
    scene.suns.push_back({{-0.4, -0.6, 0.7}, {600.0, 580.0, 520.0}});
    scene.sky = Sky{{30.0, 38.0, 50.0}, {50.0, 52.0, 54.0}, {12.0, 11.0, 9.0}};
    scene.camera = {{-0.9, -1.5, 1.4}, {0.8, 0.0, 0.35}, 36.0};
    return scene;
}

} // namespace

Scene engine(std::size_t triangles) {
    int low = 6;
    Scene scene = engine_of(low);
    if (scene.surface.triangle_count() > triangles || triangles > 10'000'000) {
        throw std::invalid_argument("the engine has " + std::to_string(scene.surface.triangle_count()) +
                                    " to 10 million triangles");
    }
    // More segments give more triangles: double until there are too many, then bisect.
    int high = 0;
    while (high == 0 || high - low > 1) {
        const int next = high == 0 ? 2 * low : (low + high) / 2;
        Scene finer = engine_of(next);
        if (finer.surface.triangle_count() > triangles) {
            high = next;
        } else {
            low = next;
            scene = std::move(finer);
        }
    }
    return scene;
}

} // namespace scenes
