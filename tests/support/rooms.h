// More meshes for tests: rooms that are not convex, thin things and bad triangles. See also meshes.h.
#pragma once

#include <difusa/import/shapes.h>

#include <meshes.h>

namespace difusa::test {

/// A rectangle in the plane z = 0 that faces up, or down, cut along one diagonal or the other.
inline Mesh flat_rectangle(double x0, double y0, double x1, double y1, bool up = true, bool other_diagonal = false) {
    const Vec3 a(x0, y0, 0), along_x(x1 - x0, 0, 0), along_y(0, y1 - y0, 0);
    const Vec3 &u = up ? along_x : along_y, &v = up ? along_y : along_x;
    return other_diagonal ? rectangle(a + u, v, -u) : rectangle(a, u, v);
}

/// The mesh turned by R, then scaled, then moved.
inline Mesh transformed(Mesh mesh, const Eigen::Matrix3d& R, double scale, const Vec3& offset) {
    for (Vec3& point : mesh.points) {
        point = scale * (R * point) + offset;
    }
    mesh.derive();
    return mesh;
}

/// An L-shaped room of three unit cubes around the corner (1, 1), closed, seen from inside.
inline Mesh l_room() {
    const std::vector<std::array<double, 2>> plan{{0, 0}, {1, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}, {0, 1}};
    std::vector<Vec3> points;
    for (const double z : {0.0, 1.0}) {
        for (const auto& p : plan) {
            points.emplace_back(p[0], p[1], z);
        }
    }
    std::vector<std::array<Index, 3>> triangles;
    const auto quad = [&](Index a, Index b, Index c, Index d) {
        triangles.push_back({a, b, c});
        triangles.push_back({a, c, d});
    };
    for (const auto& square : {std::array<Index, 4>{0, 1, 4, 7}, {1, 2, 3, 4}, {7, 4, 5, 6}}) {
        quad(square[0], square[1], square[2], square[3]);                 // floor, facing up
        quad(square[3] + 8, square[2] + 8, square[1] + 8, square[0] + 8); // ceiling, facing down
    }
    for (Index k = 0; k < 8; ++k) { // the plan runs counterclockwise: walls face its inside
        const Index next = (k + 1) % 8;
        quad(k, k + 8, next + 8, next);
    }
    return make_mesh(std::move(points), std::move(triangles));
}

/// In the L-shaped room: the straight line does not pass through the walls x = 1, y > 1 and y = 1, x > 1. Points of
/// these walls are in them up to rounding.
inline bool see_in_l_room(const Vec3& p, const Vec3& q) {
    const auto passes = [&](int across, int along) {
        return (p[across] - 1.0) * (q[across] - 1.0) < -1e-20 &&
               p[along] + (1.0 - p[across]) / (q[across] - p[across]) * (q[along] - p[along]) > 1.0;
    };
    return !passes(0, 1) && !passes(1, 0);
}

/// The unit cube seen from inside, with a block in the middle of it seen from outside.
inline Mesh room_with_block() {
    return together(box(1.0, 1, true), moved(box(Vec3(0.3, 0.2, 0.4)), 1.0, Vec3(0.35, 0.45, 0.25)));
}

/// The unit square at z = 0 cut into `count` needles that all meet in one corner.
inline Mesh needles(int count) {
    std::vector<Vec3> points{{0, 0, 0}};
    std::vector<std::array<Index, 3>> triangles;
    for (int k = 0; k <= count; ++k) {
        const double s = 2.0 * k / count;
        points.emplace_back(s <= 1.0 ? Vec3(1, s, 0) : Vec3(2.0 - s, 1, 0));
    }
    for (Index k = 1; k <= static_cast<Index>(count); ++k) {
        triangles.push_back({0, k, k + 1});
    }
    return make_mesh(std::move(points), std::move(triangles));
}

/// One right triangle with legs 1, and beside it a strip of 2 n² triangles in the square [-size, 0] × [0, size].
inline Mesh huge_among_tiny(int n, double size) {
    const Mesh huge = make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
    return together(huge, moved(grid(n, n, size, size), 1.0, Vec3(-size, 0, 0)));
}

/// A wall of two triangles a side, `thickness` thick, closed, outward.
inline Mesh thin_wall(double thickness) {
    return box(Vec3(1.0, thickness, 1.0));
}

/// A table [0,1]² at z = 0 and a shelf over part of it at height `gap`, both facing up.
inline Mesh shelf_over_table(double gap) {
    return together(grid(2, 2), moved(grid(1, 1, 0.5, 0.5), 1.0, Vec3(0.25, 0.25, gap)));
}

/// The point is on that table, below the shelf.
inline bool under_shelf(const Vec3& x) {
    return x.z() == 0.0 && (x - Vec3(0.5, 0.5, 0.0)).cwiseAbs().maxCoeff() < 0.25;
}

/// On that table, or on the shelf: no light gets from the open table below the shelf if the gap is next to nothing.
inline bool see_on_table(const Vec3& p, const Vec3& q) {
    return under_shelf(p) == under_shelf(q);
}

} // namespace difusa::test
