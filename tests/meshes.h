// Meshes for tests: closed, open and awkward ones, each derived, of one material, with
// original_face[t] = t. Normals point outward (or along +z) unless `inward`.
#pragma once

#include <difusa/mesh/mesh.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

namespace difusa::test {

/// Turns every triangle over and derives anew.
inline void flip(Mesh& mesh) {
    for (auto& triangle : mesh.triangles) {
        std::swap(triangle[1], triangle[2]);
    }
    mesh.derive();
}

/// A mesh of these points and triangles.
inline Mesh make_mesh(std::vector<Vec3> points, std::vector<std::array<Index, 3>> triangles, bool inward = false) {
    Mesh mesh;
    mesh.points = std::move(points);
    mesh.triangles = std::move(triangles);
    mesh.original_face.resize(mesh.triangles.size());
    std::iota(mesh.original_face.begin(), mesh.original_face.end(), Index{0});
    mesh.material.assign(mesh.triangles.size(), 0);
    if (inward) {
        flip(mesh);
    } else {
        mesh.derive();
    }
    return mesh;
}

/// The same surface moved by x -> scale x + offset.
inline Mesh moved(Mesh mesh, double scale, const Vec3& offset) {
    for (Vec3& point : mesh.points) {
        point = scale * point + offset;
    }
    mesh.derive();
    return mesh;
}

/// Both surfaces in one mesh, not welded; the triangles of `b` follow those of `a`.
inline Mesh together(Mesh a, const Mesh& b) {
    const auto shift = static_cast<Index>(a.points.size());
    a.points.insert(a.points.end(), b.points.begin(), b.points.end());
    for (auto triangle : b.triangles) {
        for (Index& corner : triangle) {
            corner += shift;
        }
        a.triangles.push_back(triangle);
    }
    return make_mesh(std::move(a.points), std::move(a.triangles));
}

/// The rectangle [0,width] × [0,depth] at z = 0, facing +z, of 2 nx ny triangles. Cell (i, j) has the triangles
/// 2 (j nx + i), below its diagonal, and the next.
inline Mesh grid(int nx, int ny, double width = 1.0, double depth = 1.0, bool inward = false) {
    std::vector<Vec3> points;
    std::vector<std::array<Index, 3>> triangles;
    for (int j = 0; j <= ny; ++j) {
        for (int i = 0; i <= nx; ++i) {
            points.emplace_back(width * i / nx, depth * j / ny, 0.0);
        }
    }
    for (int j = 0; j < ny; ++j) {
        for (int i = 0; i < nx; ++i) {
            const auto a = static_cast<Index>(j * (nx + 1) + i);
            const auto d = a + static_cast<Index>(nx) + 1;
            triangles.push_back({a, a + 1, d + 1});
            triangles.push_back({a, d + 1, d});
        }
    }
    return make_mesh(std::move(points), std::move(triangles), inward);
}

/// The box [0,x] × [0,y] × [0,z], watertight, each side cut into n × n rectangles: 12 n² triangles, 2 n² a side in
/// the order -x +x -y +y -z +z.
inline Mesh box(const Vec3& size, int n = 1, bool inward = false) {
    std::vector<Vec3> points;
    std::vector<std::array<Index, 3>> triangles;
    std::map<std::array<int, 3>, Index> number; // lattice point -> point
    const auto point = [&](const std::array<int, 3>& lattice) {
        const auto [place, is_new] = number.try_emplace(lattice, static_cast<Index>(points.size()));
        if (is_new) {
            points.emplace_back(size.x() * lattice[0] / n, size.y() * lattice[1] / n, size.z() * lattice[2] / n);
        }
        return place->second;
    };
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (const bool high : {false, true}) {
            // (axis, first, second) is right-handed, so a quad that runs first, second faces +axis.
            const std::size_t first = high ? (axis + 1) % 3 : (axis + 2) % 3;
            const std::size_t second = high ? (axis + 2) % 3 : (axis + 1) % 3;
            for (int j = 0; j < n; ++j) {
                for (int i = 0; i < n; ++i) {
                    std::array<std::array<int, 3>, 4> quad{};
                    for (std::size_t k = 0; k < 4; ++k) {
                        quad[k][axis] = high ? n : 0;
                        quad[k][first] = i + (k == 1 || k == 2 ? 1 : 0);
                        quad[k][second] = j + (k >= 2 ? 1 : 0);
                    }
                    const std::array<Index, 4> corner{point(quad[0]), point(quad[1]), point(quad[2]), point(quad[3])};
                    triangles.push_back({corner[0], corner[1], corner[2]});
                    triangles.push_back({corner[0], corner[2], corner[3]});
                }
            }
        }
    }
    return make_mesh(std::move(points), std::move(triangles), inward);
}

/// The cube [0,size]³.
inline Mesh box(double size, int n = 1, bool inward = false) {
    return box(Vec3::Constant(size), n, inward);
}

/// A sphere around the origin: the icosahedron with each triangle quartered `level` times, its points pushed out to
/// `radius`. 20 · 4^level triangles.
inline Mesh icosphere(int level, double radius = 1.0, bool inward = false) {
    const double g = std::numbers::phi;
    std::vector<Vec3> points{{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                             {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
    std::vector<std::array<Index, 3>> triangles{{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                                {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                                {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                                {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
    for (Vec3& point : points) {
        point.normalize();
    }
    for (int l = 0; l < level; ++l) {
        std::map<std::pair<Index, Index>, Index> middle;
        std::vector<std::array<Index, 3>> finer;
        for (const auto& t : triangles) {
            std::array<Index, 3> m{};
            for (std::size_t k = 0; k < 3; ++k) {
                const Index a = t[k], b = t[(k + 1) % 3];
                const auto [place, is_new] = middle.try_emplace(std::minmax(a, b), static_cast<Index>(points.size()));
                if (is_new) {
                    points.push_back((points[a] + points[b]).normalized());
                }
                m[k] = place->second;
            }
            finer.push_back({t[0], m[0], m[2]});
            finer.push_back({t[1], m[1], m[0]});
            finer.push_back({t[2], m[2], m[1]});
            finer.push_back(m);
        }
        triangles = std::move(finer);
    }
    for (Vec3& point : points) {
        point *= radius;
    }
    return make_mesh(std::move(points), std::move(triangles), inward);
}

/// `pages` unit squares (two triangles each) around a common spine on the z axis, at equal angles and all running
/// through the spine in the same direction. Three or more make a non-manifold edge.
inline Mesh book(int pages) {
    std::vector<Vec3> points{{0, 0, 0}, {0, 0, 1}};
    std::vector<std::array<Index, 3>> triangles;
    for (int p = 0; p < pages; ++p) {
        const double angle = 2 * std::numbers::pi * p / pages;
        const auto outer = static_cast<Index>(points.size());
        points.emplace_back(std::cos(angle), std::sin(angle), 0.0);
        points.emplace_back(std::cos(angle), std::sin(angle), 1.0);
        triangles.push_back({0, outer, outer + 1});
        triangles.push_back({0, outer + 1, 1});
    }
    return make_mesh(std::move(points), std::move(triangles));
}

/// A Möbius strip of 2 `segments` triangles around the z axis, middle radius 1, width 2 `half_width`: it cannot be
/// oriented, so across one of its cross edges both triangles run in the same direction.
inline Mesh mobius(int segments, double half_width = 0.3) {
    std::vector<Vec3> points;
    std::vector<std::array<Index, 3>> triangles;
    for (int s = 0; s < segments; ++s) {
        const double angle = 2 * std::numbers::pi * s / segments;
        for (const double side : {-half_width, half_width}) {
            const double radius = 1.0 + side * std::cos(angle / 2);
            points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), side * std::sin(angle / 2));
        }
    }
    for (int s = 0; s < segments; ++s) {
        const auto a = static_cast<Index>(2 * s), b = a + 1;
        const bool closes = s + 1 == segments; // where the strip's sides change places
        const Index c = closes ? 1 : a + 2, d = closes ? 0 : a + 3;
        triangles.push_back({a, b, d});
        triangles.push_back({a, d, c});
    }
    return make_mesh(std::move(points), std::move(triangles));
}

} // namespace difusa::test
