#include <difusa/core/frame.h>
#include <difusa/import/shapes.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/rays/brute_force.h>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <meshes.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace difusa::surface_sampling_test {
namespace {

TEST(SurfaceSampling, EveryTriangleHasItsShareOfPoints) {
    const Mesh mesh = test::icosphere(2, 1.0);
    constexpr std::size_t n = 5000;
    std::vector<int> count(mesh.triangles.size(), 0);
    for (const SurfacePoint& x : even_points(mesh, n, RandomStream(1, "points"))) {
        ++count[x.face];
        EXPECT_TRUE(x.u >= 0.0 && x.v >= 0.0 && x.u + x.v <= 1.0);
        const SurfacePoint same = mesh.shaded(mesh.at(x.face, x.u, x.v));
        EXPECT_EQ(x.normal, same.normal);
        EXPECT_LT((same.position - x.position).norm(), 1e-15);
    }
    for (std::size_t t = 0; t < count.size(); ++t) {
        // One point from each of n equal shares: a triangle cuts at most two of them at its ends.
        EXPECT_LT(std::abs(count[t] - mesh.areas[t] / mesh.area * n), 2.0);
    }
}

/// ∫ x² over the unit square is 1/3, by points that are uniform within their triangle.
TEST(SurfaceSampling, PointsAreUniformWithinTriangles) {
    const Mesh mesh = test::grid(1, 1);
    constexpr std::size_t n = 20000;
    double mean = 0.0;
    for (const SurfacePoint& x : even_points(mesh, n, RandomStream(1, "points"))) {
        mean += x.position.x() * x.position.x() / n;
    }
    EXPECT_NEAR(mean, 1.0 / 3.0, 4.5 * std::sqrt(4.0 / 45.0 / n)); // variance of x² is 1/5 - 1/9
}

TEST(SurfaceSampling, InsetLeavesPointsInsideWhereTheyAre) {
    const Mesh mesh = test::icosphere(1, 1.0);
    for (const SurfacePoint& x : even_points(mesh, 100, RandomStream(1, "points"))) {
        if (std::min({x.u, x.v, 1.0 - x.u - x.v}) > 0x1p-15) {
            EXPECT_EQ(inset(mesh, x).position, x.position);
        }
    }
}

TEST(SurfaceSampling, InsetPointsLieInsideAndNear) {
    for (const double scale : {1e-6, 1.0, 1e6}) {
        for (const Vec3& offset : {Vec3(0, 0, 0), Vec3(1e3, 2e3, -1e3)}) {
            const Mesh mesh = test::moved(test::icosphere(1, 1.0), scale, scale * offset);
            for (Index t = 0; t < mesh.triangles.size(); ++t) {
                for (const auto& [u, v] :
                     {std::pair(0.0, 0.0), std::pair(1.0, 0.0), std::pair(0.5, 0.5), std::pair(0.0, 0.3)}) {
                    SurfacePoint x = mesh.at(t, u, v);
                    x.normal = Vec3::UnitX();
                    const SurfacePoint y = inset(mesh, x);
                    EXPECT_GT(std::min({y.u, y.v, 1.0 - y.u - y.v}), 0x1p-17);
                    EXPECT_EQ(y.normal, x.normal);
                    EXPECT_EQ(y.face, t);
                    EXPECT_LT((y.position - x.position).norm(), 0x1p-11 * scale);
                }
            }
        }
    }
}

/// The corner of a cube, whose walls are two triangles each: on each wall the point is as far from one edge as from the
/// other, whichever triangle is asked, and whether the diagonal meets the corner or not.
TEST(SurfaceSampling, InsetIsOnTheBisectorOfCorners) {
    const Mesh mesh = test::box(1.0, 1, true);
    std::size_t corners = 0;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        for (const auto& [u, v] : {std::pair(0.0, 0.0), std::pair(1.0, 0.0), std::pair(0.0, 1.0)}) {
            const SurfacePoint x = mesh.at(t, u, v), y = inset(mesh, x);
            Vec3 moved = (y.position - x.position).cwiseAbs();
            std::sort(moved.begin(), moved.end());
            EXPECT_EQ(moved[0], 0.0);
            EXPECT_GT(moved[1], 0x1p-17);
            EXPECT_NEAR(moved[1], moved[2], 0x1p-9 * moved[1]); // 2^-11 beside the diagonal
            ++corners;
        }
    }
    EXPECT_EQ(corners, 36U);
}

/// Within a plane points are hardly moved; beside an edge of it they are moved away by about 2^-16 of a triangle.
TEST(SurfaceSampling, InsetIgnoresEdgesWithinAPlane) {
    const Mesh mesh = test::grid(4, 4); // triangles of size 1/4
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        for (const auto& [u, v] :
             {std::pair(0.0, 0.0), std::pair(1.0, 0.0), std::pair(0.5, 0.5), std::pair(0.0, 0.3)}) {
            const SurfacePoint x = mesh.at(t, u, v), y = inset(mesh, x);
            const auto on_edge = [](double c) { return c == 0.0 || c == 1.0; };
            if (on_edge(x.position.x()) || on_edge(x.position.y())) {
                EXPECT_GT((y.position - x.position).norm(), 0x1p-20) << x.position.transpose();
            } else {
                EXPECT_LT((y.position - x.position).norm(), 0x1p-21) << x.position.transpose();
            }
        }
    }
}

/// A turned box whose coordinates are rounded to single precision, so that the two triangles of a wall are in one plane
/// only nearly: wherever they start, no ray meets the back of a wall of a closed room.
TEST(SurfaceSampling, RaysFromInsetPointsStayInside) {
    const Mesh box = test::box(Vec3(3, 2, 1), 2, true);
    for (int turn = 1; turn <= 20; ++turn) {
        const Eigen::Matrix3d rotation(Eigen::AngleAxisd(turn, Vec3(1, turn, 2).normalized()));
        std::vector<Vec3> points;
        for (const Vec3& p : box.points) {
            points.emplace_back((rotation * p + Vec3(5, 6, 7)).cast<float>().cast<double>());
        }
        const Mesh mesh = test::make_mesh(std::move(points), box.triangles);
        BruteForceVisibility engine;
        engine.build(mesh);
        RandomStream stream(1, "rays", static_cast<std::uint64_t>(turn));
        for (Index t = 0; t < mesh.triangles.size(); ++t) {
            for (const auto& [u, v] : {std::pair(0.0, 0.0), std::pair(1.0, 0.0), std::pair(0.0, 1.0),
                                       std::pair(0.5, 0.5), std::pair(0.5, 0.0), std::pair(0.0, 0.5)}) {
                const SurfacePoint y = inset(mesh, mesh.at(t, u, v));
                EXPECT_GT(std::min({y.u, y.v, 1.0 - y.u - y.v}), 0x1p-28);
                EXPECT_EQ(y.position, mesh.at(y.face, y.u, y.v).position);
                for (int k = 0; k < 8; ++k) {
                    const double up = stream.uniform(), angle = 2.0 * std::numbers::pi * stream.uniform();
                    const Ray ray{y.position, cosine_direction(mesh.normals[y.face], up, angle), y.face};
                    Hit hit;
                    engine.first_hits({&ray, 1}, {&hit, 1});
                    EXPECT_TRUE(hit.face != none && hit.front) << turn << " " << t;
                }
            }
        }
    }
}

/// Number of times each directed edge occurs: closed surfaces have each edge once in either direction.
bool closed(const Mesh& mesh) {
    std::map<std::pair<Index, Index>, int> edges;
    for (const auto& t : mesh.triangles) {
        for (std::size_t k = 0; k < 3; ++k) {
            ++edges[{t[k], t[(k + 1) % 3]}];
        }
    }
    for (const auto& [edge, count] : edges) {
        const auto back = edges.find({edge.second, edge.first});
        if (count != 1 || back == edges.end() || back->second != 1) {
            return false;
        }
    }
    return true;
}

double volume(const Mesh& mesh) {
    double sum = 0.0;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        sum += mesh.corner(t, 0).dot(mesh.corner(t, 1).cross(mesh.corner(t, 2))) / 6.0;
    }
    return sum;
}

TEST(Shapes, BoxesAreClosedAndFaceTheirWay) {
    for (const Front front : {Front::outside, Front::inside}) {
        const Mesh mesh = box(Vec3(-1, 0, 2), Vec3(1, 3, 2.5), 3, front);
        EXPECT_TRUE(closed(mesh));
        EXPECT_EQ(mesh.triangles.size(), 6U * 9U * 2U);
        EXPECT_NEAR(mesh.area, 2.0 * (2 * 3 + 3 * 0.5 + 2 * 0.5), 1e-13);
        EXPECT_NEAR(volume(mesh), (front == Front::outside ? 1.0 : -1.0) * 3.0, 1e-13);
        for (Index t = 0; t < mesh.triangles.size(); ++t) { // the material tells the face
            const Eigen::Index axis = mesh.material[t] / 2;
            const double way = (mesh.material[t] % 2 == 1) == (front == Front::outside) ? 1.0 : -1.0;
            EXPECT_LT((mesh.normals[t] - way * Vec3::Unit(axis)).norm(), 1e-15);
        }
    }
}

TEST(Shapes, SpheresAreClosedAndTendToTheirAreaWithTheSquareOfTheEdge) {
    double last = 0.0;
    for (int halvings = 1; halvings <= 4; ++halvings) {
        const Mesh mesh = sphere(2.0, halvings, Front::outside);
        EXPECT_TRUE(closed(mesh));
        EXPECT_EQ(mesh.triangles.size(), 20U << (2U * static_cast<unsigned>(halvings)));
        EXPECT_GT(volume(mesh), 0.0);
        EXPECT_LT(volume(sphere(2.0, halvings, Front::inside)), 0.0);
        for (const Vec3& p : mesh.points) {
            EXPECT_NEAR(p.norm(), 2.0, 1e-15 * 4);
        }
        const double missing = 16.0 * std::numbers::pi - mesh.area;
        EXPECT_GT(missing, 0.0);
        if (halvings > 1) {
            EXPECT_NEAR(last / missing, 4.0, 0.6);
        }
        last = missing;
    }
}

TEST(Shapes, DiscsCapsAndCylindersHaveTheAreasOfTheirPolygons) {
    constexpr int n = 7;
    constexpr double pi = std::numbers::pi;
    const Mesh flat = disc(3.0, n);
    EXPECT_NEAR(flat.area, 9.0 * 0.5 * 6 * n * std::sin(2.0 * pi / (6 * n)), 1e-12);
    EXPECT_EQ(flat.triangles.size(), 6U * n * n);
    for (const Vec3& normal : flat.normals) {
        EXPECT_LT((normal - Vec3::UnitZ()).norm(), 1e-15);
    }
    const Mesh wall = cylinder(2.0, 5.0, 12, 3, Front::inside);
    EXPECT_NEAR(wall.area, 12 * 2.0 * 2.0 * std::sin(pi / 12) * 5.0, 1e-12);
    for (Index t = 0; t < wall.triangles.size(); ++t) {
        const Vec3 centre = wall.at(t, 1.0 / 3, 1.0 / 3).position;
        EXPECT_LT(wall.normals[t].dot(Vec3(centre.x(), centre.y(), 0)), 0.0);
    }
    for (const Front front : {Front::inside, Front::outside}) {
        const Mesh cap = spherical_cap(2.0, 1.2, 24, front);
        EXPECT_NEAR(cap.area, 2.0 * pi * 4.0 * (1.0 - std::cos(1.2)), 0.01 * cap.area);
        for (Index t = 0; t < cap.triangles.size(); ++t) {
            EXPECT_EQ(cap.normals[t].dot(cap.corner(t, 0)) < 0.0, front == Front::inside);
        }
    }
}

} // namespace
} // namespace difusa::surface_sampling_test
