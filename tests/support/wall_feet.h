// Pairs of rooms over one floor, parted by walls that stand on it by all kinds of feet. No light can pass.
#pragma once

#include <difusa/core/random.h>
#include <difusa/import/shapes.h>

#include <support/lit_scenes.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace difusa::feet {

/// Two rooms, [0,2] × [0,1] × [0,1] together, the lit one at small x; material 1 is the lamp.
struct TwoRooms {
    std::string name;
    Mesh mesh;
    std::function<bool(const Vec3&)> is_dark; ///< of points in the air
};

/// Points at the same place made one, as the diagnosis does.
inline Mesh welded(Mesh mesh) {
    std::map<std::array<double, 3>, Index> number;
    std::vector<Vec3> points;
    for (auto& triangle : mesh.triangles) {
        for (Index& corner : triangle) {
            const Vec3& p = mesh.points[corner];
            const auto [place, is_new] = number.try_emplace({p[0], p[1], p[2]}, static_cast<Index>(points.size()));
            if (is_new) {
                points.push_back(p);
            }
            corner = place->second;
        }
    }
    mesh.points = std::move(points);
    mesh.derive();
    return mesh;
}

/// The sides of the rooms without a floor, the floor, what stands between them, and the lamp.
inline Mesh rooms_with(const Mesh& floor, const Mesh& wall) {
    Mesh mesh = lit::plain_box(Vec3::Zero(), Vec3(2, 1, 1), 1, Front::inside);
    std::erase_if(mesh.triangles, [&](const auto& t) {
        return std::all_of(t.begin(), t.end(), [&](Index p) { return mesh.points[p].z() == 0.0; });
    });
    mesh = test::make_mesh(mesh.points, mesh.triangles);
    add(mesh, floor, 0);
    add(mesh, wall, 0);
    add(mesh, rectangle(Vec3(0.35, 0.4, 0.9), Vec3(0, 0.2, 0), Vec3(0.2, 0, 0)), 1);
    return welded(std::move(mesh));
}

inline Mesh flat_floor(int n) {
    return rectangle(Vec3::Zero(), Vec3(2, 0, 0), Vec3(0, 1, 0), n, n);
}

/// A line in the plane of x and z.
using Profile = std::vector<std::array<double, 2>>;

/// What the profile sweeps from y = low to high; its front is to the left.
inline Mesh swept(const Profile& profile, double low = 0.0, double high = 1.0) {
    std::vector<Vec3> points;
    std::vector<std::array<Index, 3>> triangles;
    for (const auto& [x, z] : profile) {
        points.emplace_back(x, low, z);
        points.emplace_back(x, high, z);
    }
    for (Index i = 0; i + 3 < points.size(); i += 2) {
        triangles.push_back({i, i + 2, i + 3});
        triangles.push_back({i, i + 3, i + 1});
    }
    return test::make_mesh(std::move(points), std::move(triangles));
}

/// A solid beam: its cross-section runs clockwise.
inline Mesh beam(Profile section) {
    section.push_back(section.front());
    return swept(section);
}

inline Mesh bar(double x0, double x1, double z0, double z1) {
    return beam({{x0, z0}, {x0, z1}, {x1, z1}, {x1, z0}});
}

/// Half of a wall around x = 1, `thickness` to the left, from its foot up: of `size`, round in `steps` or bevelled.
inline Profile half_foot(double thickness, double size, int steps) {
    Profile half;
    for (int i = 0; i <= steps; ++i) {
        const double angle = 0.5 * lit::pi * i / steps;
        half.push_back({1.0 - thickness - size * (1.0 - std::sin(angle)), size * (1.0 - std::cos(angle))});
    }
    half.push_back({1.0 - thickness, 1.0});
    return half;
}

/// The half and its mirror image.
inline Profile mirrored(Profile half) {
    for (std::size_t i = half.size(); i-- > 0;) {
        half.push_back({2.0 - half[i][0], half[i][1]});
    }
    return half;
}

/// True if a point is to the right of the right half of a mirrored profile.
inline std::function<bool(const Vec3&)> right_of(const Profile& half) {
    return [half](const Vec3& p) {
        for (std::size_t i = 0; i + 1 < half.size(); ++i) {
            const auto &a = half[i], &b = half[i + 1];
            if (p.z() >= a[1] && p.z() <= b[1] && b[1] > a[1]) {
                const double share = (p.z() - a[1]) / (b[1] - a[1]);
                return 2.0 - p.x() < a[0] + share * (b[0] - a[0]) - 1e-9;
            }
        }
        return p.x() > 1.0 && p.z() > 0.0;
    };
}

inline TwoRooms with_foot(const std::string& name, double thickness, double size, int steps, int floor = 1) {
    const Profile half = half_foot(thickness, size, steps);
    return {name, rooms_with(flat_floor(floor), swept(mirrored(half))), right_of(half)};
}

/// The heights of a rough ground at the nodes of a grid; flat at its border.
inline Mesh rough_ground(int nx, int ny, double roughness) {
    Mesh floor = rectangle(Vec3::Zero(), Vec3(2, 0, 0), Vec3(0, 1, 0), nx, ny);
    RandomStream random(5, "ground");
    for (Vec3& p : floor.points) {
        const double height = roughness * (2.0 * random.uniform() - 1.0);
        const bool inside = p.x() > 0.01 && p.x() < 1.99 && p.y() > 0.01 && p.y() < 0.99;
        p.z() = inside ? height : 0.0;
    }
    floor.derive();
    return floor;
}

inline Mesh both_sides(const Vec3& a, const Vec3& u, const Vec3& v) {
    Mesh both = rectangle(a, u, v);
    add(both, rectangle(a, v, u), 0);
    return both;
}

/// A sheet of both sides at x = 1 that stands on each node and edge of the ground there.
inline Mesh sheet_on(const Mesh& ground) {
    std::vector<Vec3> foot;
    for (const Vec3& p : ground.points) {
        if (std::abs(p.x() - 1.0) < 1e-9) {
            foot.push_back(p);
        }
    }
    std::sort(foot.begin(), foot.end(), [](const Vec3& a, const Vec3& b) { return a.y() < b.y(); });
    std::vector<Vec3> points;
    std::vector<std::array<Index, 3>> triangles;
    for (const Vec3& p : foot) {
        points.push_back(p);
        points.emplace_back(p.x(), p.y(), 1.0);
    }
    for (Index i = 0; i + 3 < points.size(); i += 2) {
        for (const auto& t : {std::array<Index, 3>{i, i + 2, i + 3}, {i, i + 3, i + 1}}) {
            triangles.push_back(t);
            triangles.push_back({t[0], t[2], t[1]});
        }
    }
    return test::make_mesh(std::move(points), std::move(triangles));
}

/// Boards that overlap, from the floor up, in turn at x = 1 and behind; then one that reaches the ceiling.
inline Mesh lapped_boards(double thickness, double height) {
    Mesh mesh;
    for (int k = 0; k < 5; ++k) {
        const double x = 1.0 + (k % 2) * thickness, z = 0.7 * height * k;
        const Mesh board = bar(x, x + thickness, z, k < 4 ? z + height : 1.0);
        if (k == 0) {
            mesh = board;
        } else {
            add(mesh, board, 0);
        }
    }
    return mesh;
}

/// A partition from the wall at y = 0 to that at y = 1, into which it is rounded off, as that is into the floor: a walk
/// leads over all of them. It stands on the floor, and sinks into the rounding below the wall, without being joined.
inline TwoRooms rounded_partition(double size) {
    const int steps = 6;
    Profile plan; // of the partition's left side, seen from above
    const double thickness = 0.3 * size;
    plan.push_back({1.0 - thickness, 0.0});
    for (int i = 0; i <= steps; ++i) {
        const double angle = 0.5 * lit::pi * i / steps;
        plan.push_back({1.0 - thickness - size * (1.0 - std::cos(angle)), 1.0 - size * (1.0 - std::sin(angle))});
    }
    const std::vector<double> levels{-0.1, 1.5 * size, 1.0};
    const auto sheet = [](const std::vector<Vec3>& low, const std::vector<Vec3>& high) {
        std::vector<Vec3> points;
        std::vector<std::array<Index, 3>> triangles;
        for (std::size_t i = 0; i < low.size(); ++i) {
            points.push_back(low[i]);
            points.push_back(high[i]);
        }
        for (Index i = 0; i + 3 < points.size(); i += 2) {
            triangles.push_back({i, i + 2, i + 3});
            triangles.push_back({i, i + 3, i + 1});
        }
        return test::make_mesh(std::move(points), std::move(triangles));
    };
    Mesh mesh = lit::plain_box(Vec3::Zero(), Vec3(2, 1, 1), 1, Front::inside);
    std::erase_if(mesh.triangles, [&](const auto& t) {
        const auto all = [&](int axis, double at) {
            return std::all_of(t.begin(), t.end(), [&](Index p) { return mesh.points[p][axis] == at; });
        };
        return all(2, 0.0) || all(1, 1.0);
    });
    mesh = test::make_mesh(mesh.points, mesh.triangles);
    for (std::size_t k = 0; k + 1 < levels.size(); ++k) {
        std::vector<Vec3> left[2], right[2];
        for (int h = 0; h < 2; ++h) {
            for (const auto& [x, y] : plan) {
                left[h].emplace_back(x, y, levels[k + static_cast<std::size_t>(h)]);
                right[h].emplace_back(2.0 - x, y, levels[k + static_cast<std::size_t>(h)]);
            }
            std::reverse(right[h].begin(), right[h].end());
        }
        add(mesh, sheet(left[1], left[0]), 0);
        add(mesh, sheet(right[1], right[0]), 0);
    }
    // Floor, rounding and wall, from x to x, in the plane of y and z.
    std::vector<std::array<double, 2>> rise{{0.0, 0.0}};
    for (int i = 0; i <= steps; ++i) {
        const double angle = 0.5 * lit::pi * i / steps;
        rise.push_back({1.0 - size * (1.0 - std::sin(angle)), size * (1.0 - std::cos(angle))});
    }
    rise.push_back({1.0, 1.5 * size});
    rise.push_back({1.0, 1.0});
    const double edge = plan.back()[0];
    const std::vector<double> cuts{0.0, edge, 2.0 - edge, 2.0};
    for (std::size_t k = 0; k + 1 < cuts.size(); ++k) {
        std::vector<Vec3> from, to;
        for (const auto& [y, height] : rise) {
            from.emplace_back(cuts[k], y, height);
            to.emplace_back(cuts[k + 1], y, height);
        }
        add(mesh, sheet(to, from), 0);
    }
    add(mesh, rectangle(Vec3(0.35, 0.4, 0.9), Vec3(0, 0.2, 0), Vec3(0.2, 0, 0)), 1);
    return {"partition rounded into a rounded room", welded(std::move(mesh)), [plan](const Vec3& p) {
                for (std::size_t i = 0; i + 1 < plan.size(); ++i) {
                    const auto &a = plan[i], &b = plan[i + 1];
                    if (p.y() >= a[1] && p.y() <= b[1] && b[1] > a[1]) {
                        return 2.0 - p.x() < a[0] + (p.y() - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) - 1e-9;
                    }
                }
                return false;
            }};
}

inline std::vector<TwoRooms> wall_feet(double size) {
    const auto beyond = [](double x) { return [x](const Vec3& p) { return p.x() > x + 1e-9; }; };
    std::vector<TwoRooms> all;
    all.push_back(with_foot("rounded foot", 0.3 * size, size, 8));
    all.push_back(with_foot("rounded foot on a finely cut floor", 0.3 * size, size, 8, 41));
    all.push_back(with_foot("bevelled foot", 0.3 * size, size, 1));
    {
        Mesh wall = bar(1.0 - 2.0 * size, 1.0, 0.0, 0.3 * size); // the carpet
        add(wall, bar(1.0, 1.0 + 0.3 * size, 0.0, 1.0), 0);
        all.push_back({"wall beside a carpet", rooms_with(flat_floor(1), wall), beyond(1.0 + 0.3 * size)});
    }
    {
        Mesh wall = bar(1.0 - 2.0 * size, 1.0, 0.0, 0.3 * size);
        add(wall, both_sides(Vec3(1.0, 0, 0.3 * size), Vec3(0, 1, 0), Vec3(0, 0, 1.0 - 0.3 * size)), 0);
        all.push_back({"wall on the edge of a carpet", rooms_with(flat_floor(1), wall), beyond(1.0)});
    }
    {
        Mesh wall = bar(1.0 - 0.2 * size, 1.0 + 0.2 * size, 0.2 * size, 1.0);
        add(wall, bar(1.0 - 0.5 * size, 1.0 - 0.2 * size, 0.0, size), 0);
        add(wall, bar(1.0 + 0.2 * size, 1.0 + 0.5 * size, 0.0, size), 0);
        all.push_back({"wall behind skirting boards", rooms_with(flat_floor(1), wall),
                       [size](const Vec3& p) { return p.x() > 1.0 + (p.z() < size ? 0.5 : 0.2) * size + 1e-9; }});
    }
    {
        const double t = 0.3 * size;
        all.push_back({"boards with lap joints", rooms_with(flat_floor(1), lapped_boards(t, size)),
                       [t](const Vec3& p) { return p.x() > 1.0 + 2.0 * t + 1e-9; }});
        Mesh first = lit::plain_box(Vec3(1.0, 0.0, 0.0), Vec3(1.0 + t, 0.52, 1.0), 1, Front::outside);
        const Mesh second = lit::plain_box(Vec3(1.0 + t, 0.48, 0.0), Vec3(1.0 + 2.0 * t, 1.0, 1.0), 1, Front::outside);
        add(first, second, 0);
        all.push_back({"panels with a lap joint", rooms_with(flat_floor(1), first), [t](const Vec3& p) {
                           return p.y() < 0.48 ? p.x() > 1.0 + t + 1e-9 : p.x() > 1.0 + 2.0 * t + 1e-9;
                       }});
    }
    const Vec3 y(0, 1, 0), z(0, 0, 1);
    {
        const Mesh ground = rough_ground(40, 20, size);
        all.push_back({"wall that crosses rough ground",
                       rooms_with(ground, both_sides(Vec3(1.013, 0, -0.1), y, 1.1 * z)), beyond(1.013)});
        all.push_back({"wall that follows rough ground", rooms_with(ground, sheet_on(ground)), beyond(1.0)});
        const Profile half = half_foot(0.3 * size, size, 4);
        Profile deep = half;
        deep.insert(deep.begin(), {half.front()[0] - 2.0 * size, -2.0 * size});
        all.push_back(
            {"bevelled wall sunk into rough ground", rooms_with(ground, swept(mirrored(deep))), right_of(deep)});
    }
    all.push_back(rounded_partition(size));
    all.push_back(
        {"wall on a finely cut floor", rooms_with(flat_floor(61), both_sides(Vec3(1, 0, 0), y, z)), beyond(1.0)});
    return all;
}

} // namespace difusa::feet
