#include <difusa/import/shapes.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace difusa {

namespace {

void add_triangle(Mesh& mesh, Index a, Index b, Index c, Index material = 0) {
    mesh.triangles.push_back({a, b, c});
    mesh.original_face.push_back(static_cast<Index>(mesh.original_face.size()));
    mesh.material.push_back(material);
}

Index add_point(Mesh& mesh, const Vec3& point) {
    mesh.points.push_back(point);
    return static_cast<Index>(mesh.points.size() - 1);
}

Mesh finished(Mesh mesh, bool turn) {
    if (turn) {
        for (auto& triangle : mesh.triangles) {
            std::swap(triangle[1], triangle[2]);
        }
    }
    mesh.derive();
    return mesh;
}

/// Rings around a centre: ring k has 6k points, (rho, angle) -> `place`; counterclockwise for increasing angles.
Mesh rings_of(int rings, const std::function<Vec3(double rho, double angle)>& place) {
    Mesh mesh;
    add_point(mesh, place(0.0, 0.0));
    std::vector<Index> inner{0};
    for (int k = 1; k <= rings; ++k) {
        const int count = 6 * k;
        std::vector<Index> outer;
        for (int i = 0; i < count; ++i) {
            outer.push_back(add_point(
                mesh, place(static_cast<double>(k) / rings, 2.0 * std::numbers::pi * static_cast<double>(i) / count)));
        }
        // Each sixth of the ring has k steps outside and k-1 inside.
        const auto in = [&](int i) { return inner[static_cast<std::size_t>(i) % inner.size()]; };
        const auto out = [&](int i) { return outer[static_cast<std::size_t>(i) % outer.size()]; };
        for (int sixth = 0; sixth < 6; ++sixth) {
            for (int i = 0; i < k; ++i) {
                const int o = sixth * k + i, j = sixth * (k - 1) + i;
                add_triangle(mesh, out(o), out(o + 1), in(j));
                if (i + 1 < k) {
                    add_triangle(mesh, in(j), out(o + 1), in(j + 1));
                }
            }
        }
        inner = std::move(outer);
    }
    return mesh;
}

} // namespace

Mesh rectangle(const Vec3& a, const Vec3& u, const Vec3& v, int nu, int nv) {
    Mesh mesh;
    for (int j = 0; j <= nv; ++j) {
        for (int i = 0; i <= nu; ++i) {
            add_point(mesh, a + (static_cast<double>(i) / nu) * u + (static_cast<double>(j) / nv) * v);
        }
    }
    for (int j = 0; j < nv; ++j) {
        for (int i = 0; i < nu; ++i) {
            const auto p = static_cast<Index>(j * (nu + 1) + i), q = p + static_cast<Index>(nu) + 1;
            add_triangle(mesh, p, p + 1, q + 1);
            add_triangle(mesh, p, q + 1, q);
        }
    }
    return finished(std::move(mesh), false);
}

Mesh box(const Vec3& low, const Vec3& high, int n, Front front) {
    // Lattice points on the surface, shared by the faces.
    Mesh mesh;
    std::map<std::array<int, 3>, Index> known;
    const auto point = [&](const std::array<int, 3>& place) {
        const auto [entry, fresh] = known.try_emplace(place, static_cast<Index>(mesh.points.size()));
        if (fresh) {
            Vec3 x;
            for (Eigen::Index axis = 0; axis < 3; ++axis) {
                const double share = static_cast<double>(place[static_cast<std::size_t>(axis)]) / n;
                x[axis] = (1.0 - share) * low[axis] + share * high[axis];
            }
            mesh.points.push_back(x);
        }
        return entry->second;
    };
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
        for (const bool far : {false, true}) {
            for (int j = 0; j < n; ++j) {
                for (int i = 0; i < n; ++i) {
                    const auto at = [&](int di, int dj) {
                        std::array<int, 3> place{};
                        place[axis] = far ? n : 0;
                        place[u] = i + di;
                        place[v] = j + dj;
                        return point(place);
                    };
                    const auto material = static_cast<Index>(2 * axis + (far ? 1 : 0));
                    // Seen from outside a far face runs counterclockwise in (u, v), a near one clockwise.
                    if (far) {
                        add_triangle(mesh, at(0, 0), at(1, 0), at(1, 1), material);
                        add_triangle(mesh, at(0, 0), at(1, 1), at(0, 1), material);
                    } else {
                        add_triangle(mesh, at(0, 0), at(1, 1), at(1, 0), material);
                        add_triangle(mesh, at(0, 0), at(0, 1), at(1, 1), material);
                    }
                }
            }
        }
    }
    return finished(std::move(mesh), front == Front::inside);
}

Mesh disc(double radius, int rings) {
    return finished(rings_of(rings,
                             [&](double rho, double angle) {
                                 return Vec3(radius * rho * std::cos(angle), radius * rho * std::sin(angle), 0.0);
                             }),
                    false);
}

Mesh spherical_cap(double radius, double half_angle, int rings, Front front) {
    Mesh mesh = rings_of(rings, [&](double rho, double angle) {
        const double theta = rho * half_angle, sine = std::sin(theta);
        return Vec3(radius * sine * std::cos(angle), radius * sine * std::sin(angle), -radius * std::cos(theta));
    });
    // Counterclockwise from above, that is from inside.
    return finished(std::move(mesh), front == Front::outside);
}

Mesh sphere(double radius, int halvings, Front front) {
    Mesh mesh;
    const double golden = 0.5 * (1.0 + std::sqrt(5.0));
    for (const auto& [a, b] :
         {std::pair(1.0, golden), std::pair(-1.0, golden), std::pair(1.0, -golden), std::pair(-1.0, -golden)}) {
        add_point(mesh, Vec3(a, b, 0.0));
        add_point(mesh, Vec3(0.0, a, b));
        add_point(mesh, Vec3(b, 0.0, a));
    }
    // The faces are the triples of points at distance 2 (edges of the icosahedron), turned outward.
    for (Index a = 0; a < 12; ++a) {
        for (Index b = a + 1; b < 12; ++b) {
            for (Index c = b + 1; c < 12; ++c) {
                const Vec3 &p = mesh.points[a], &q = mesh.points[b], &r = mesh.points[c];
                const auto edge = [](const Vec3& x, const Vec3& y) { return (x - y).squaredNorm() < 4.5; };
                if (edge(p, q) && edge(q, r) && edge(r, p)) {
                    const bool outward = (q - p).cross(r - p).dot(p) > 0.0;
                    add_triangle(mesh, a, outward ? b : c, outward ? c : b);
                }
            }
        }
    }
    for (int k = 0; k < halvings; ++k) {
        Mesh finer;
        finer.points = mesh.points;
        std::map<std::pair<Index, Index>, Index> middle;
        const auto between = [&](Index a, Index b) {
            const auto [entry, fresh] = middle.try_emplace(std::minmax(a, b), static_cast<Index>(finer.points.size()));
            if (fresh) {
                finer.points.push_back(finer.points[a].normalized() + finer.points[b].normalized());
            }
            return entry->second;
        };
        for (const auto& [a, b, c] : mesh.triangles) {
            const Index ab = between(a, b), bc = between(b, c), ca = between(c, a);
            add_triangle(finer, a, ab, ca);
            add_triangle(finer, b, bc, ab);
            add_triangle(finer, c, ca, bc);
            add_triangle(finer, ab, bc, ca);
        }
        mesh = std::move(finer);
    }
    for (Vec3& point : mesh.points) {
        point = radius * point.normalized();
    }
    return finished(std::move(mesh), front == Front::inside);
}

Mesh cylinder(double radius, double length, int n, int m, Front front) {
    Mesh mesh;
    for (int j = 0; j <= m; ++j) {
        for (int i = 0; i < n; ++i) {
            const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / n;
            add_point(mesh, Vec3(radius * std::cos(angle), radius * std::sin(angle),
                                 length * (static_cast<double>(j) / m - 0.5)));
        }
    }
    for (int j = 0; j < m; ++j) {
        for (int i = 0; i < n; ++i) {
            const auto p = static_cast<Index>(j * n + i), q = static_cast<Index>(j * n + (i + 1) % n);
            add_triangle(mesh, p, q, q + static_cast<Index>(n));
            add_triangle(mesh, p, q + static_cast<Index>(n), p + static_cast<Index>(n));
        }
    }
    return finished(std::move(mesh), front == Front::inside);
}

void move(Mesh& mesh, const Vec3& offset) {
    for (Vec3& point : mesh.points) {
        point += offset;
    }
    mesh.derive();
}

void add(Mesh& mesh, const Mesh& other, Index material) {
    const auto first = static_cast<Index>(mesh.points.size());
    mesh.points.insert(mesh.points.end(), other.points.begin(), other.points.end());
    for (std::size_t t = 0; t < other.triangles.size(); ++t) {
        const auto& [a, b, c] = other.triangles[t];
        add_triangle(mesh, first + a, first + b, first + c, material + other.material[t]);
    }
    mesh.derive();
}

} // namespace difusa
