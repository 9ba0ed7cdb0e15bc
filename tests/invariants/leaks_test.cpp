// A lit and a dark room over one floor: no light gets through the wall between, wherever it stands and however finely
// floor and wall are cut, with any basis.
#include "support/sanitized.h"

#include <difusa/bake.h>
#include <difusa/import/shapes.h>
#include <difusa/mesh/surface_sampling.h>

#include <support/lit_scenes.h>
#include <support/rooms.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace difusa::leaks_test {
namespace {

using namespace lit;

/// Where the light must not come.
using Dark = std::function<bool(const Vec3&)>;

struct TwoRooms {
    std::string name;
    Mesh mesh; ///< material 1: the lamp
    Dark is_dark;
};

/// Both sides of a parallelogram.
Mesh sheet(const Vec3& a, const Vec3& u, const Vec3& v, int n = 1) {
    Mesh both = rectangle(a, u, v, n, n);
    add(both, rectangle(a, v, u, n, n), 0);
    return both;
}

/// The room [0,2] × [0,1] × [0,1], each of its sides of 2 n² triangles, with `wall` in it and a lamp near x = 0.45.
Mesh divided(const Mesh& wall, int n = 1) {
    Mesh mesh = plain_box(Vec3::Zero(), Vec3(2, 1, 1), n, Front::inside);
    add(mesh, wall, 0);
    add(mesh, rectangle(Vec3(0.35, 0.4, 0.9), Vec3(0, 0.2, 0), Vec3(0.2, 0, 0)), 1);
    return mesh;
}

std::vector<TwoRooms> rooms() {
    const Dark beyond_one = [](const Vec3& p) { return p.x() > 1.0 + 1e-9; };
    std::vector<TwoRooms> all;
    const Vec3 foot(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
    all.push_back({"wall of two triangles a side", divided(sheet(foot, y, z)), beyond_one});
    all.push_back({"floor finer than the surfels", divided(sheet(foot, y, z), 61), beyond_one});
    all.push_back({"wall finely cut", divided(sheet(foot, y, z, 40)), beyond_one});
    all.push_back({"wall that crosses floor, ceiling and walls", divided(sheet(Vec3(1, -0.1, -0.1), 1.2 * y, 1.2 * z)),
                   beyond_one});
    all.push_back({"oblique wall that crosses", divided(sheet(Vec3(0.85, -0.1, -0.1), Vec3(0.3, 1.2, 0), 1.2 * z)),
                   [](const Vec3& p) { return p.x() - 0.85 > 0.25 * (p.y() + 0.1) + 1e-9; }});
    all.push_back({"wall that leans and crosses", divided(sheet(Vec3(0.85, -0.1, -0.1), 1.2 * y, Vec3(0.3, 0, 1.2))),
                   [](const Vec3& p) { return p.x() - 0.85 > 0.25 * (p.z() + 0.1) + 1e-9; }});
    all.push_back({"thick wall", divided(plain_box(Vec3(1, 0, 0), Vec3(1.05, 1, 1), 1, Front::outside)),
                   [](const Vec3& p) { return p.x() > 1.05 + 1e-9; }});
    all.push_back({"thick wall that crosses",
                   divided(plain_box(Vec3(1, -0.1, -0.1), Vec3(1.05, 1.1, 1.1), 1, Front::outside)),
                   [](const Vec3& p) { return p.x() > 1.05 + 1e-9; }});
    Mesh cross = sheet(foot, y, z);
    add(cross, sheet(Vec3(0, 0.5, 0), Vec3(2, 0, 0), z), 0);
    Mesh crossed = plain_box(Vec3::Zero(), Vec3(2, 1, 1), 1, Front::inside);
    add(crossed, cross, 0);
    add(crossed, rectangle(Vec3(0.35, 0.2, 0.9), Vec3(0, 0.1, 0), Vec3(0.2, 0, 0)), 1);
    all.push_back(
        {"cross of two walls", crossed, [](const Vec3& p) { return p.x() > 1.0 + 1e-9 || p.y() > 0.5 + 1e-9; }});
    return all;
}

Scene scene_of_rooms(const Mesh& mesh) {
    Scene scene = scene_of(mesh, 0.7);
    scene.materials.resize(2, scene.materials[0]);
    scene.materials[1].emission = Rgb::Ones();
    return scene;
}

/// The largest irradiance at output vertices that are dark, and at random places; those on the wall itself count if
/// they look into the dark.
double light_in_the_dark(const TwoRooms& rooms, const BakeResult& result, double& lit, SurfacePoint& worst) {
    double most = 0.0;
    const Mesh& mesh = result.scene->mesh;
    const auto see = [&](const SurfacePoint& x, double H) {
        // A step off the surface tells the sides of a wall apart. What is on the line of a wall is on neither side.
        const Vec3 p = x.position + 1e-4 * mesh.normals[x.face];
        bool dark = true;
        for (int axis = 0; axis < 3; ++axis) {
            const Vec3 step = 5e-5 * Vec3::Unit(axis);
            dark = dark && rooms.is_dark(p + step) && rooms.is_dark(p - step);
        }
        double& side = dark ? most : lit;
        if (H > side && &side == &most) {
            worst = x;
        }
        side = std::max(side, H);
    };
    for (std::size_t v = 0; v < result.mesh.vertices.size(); ++v) {
        see(result.mesh.vertices[v], result.output.H(static_cast<Eigen::Index>(v), 0));
    }
    const std::vector<SurfacePoint> x = even_points(mesh, 1000, RandomStream(3, "places"));
    const PointValues values = result.field().at(x, 0, 5, "places", Execution{});
    for (std::size_t i = 0; i < x.size(); ++i) {
        see(x[i], values.H(static_cast<Eigen::Index>(i), 0));
    }
    return most;
}

// Under the sanitizers the same walls, met by fewer supports.
const std::vector<double> leak_spacings =
    test::sanitized() ? std::vector<double>{0.23} : std::vector<double>{0.1, 0.23};

class LightLeaks : public testing::TestWithParam<std::string> {};

TEST_P(LightLeaks, NoneBesideTheWall) {
    for (const TwoRooms& rooms : rooms()) {
        for (const double spacing : leak_spacings) {
            SCOPED_TRACE(rooms.name + ", spacing " + std::to_string(spacing));
            BakeOptions options = quick(spacing, 32);
            options.basis = GetParam();
            options.every_surface = true;
            const BakeResult result = baked(scene_of_rooms(rooms.mesh), options);
            double lit = 0.0;
            SurfacePoint worst;
            EXPECT_LE(light_in_the_dark(rooms, result, lit, worst), 1e-12)
                << "at " << worst.position.transpose() << " on face " << worst.face << " facing "
                << result.scene->mesh.normals[worst.face].transpose();
            EXPECT_GT(lit, 0.02); // the lamp alone, straight above: about area / (pi distance²)
        }
    }
}

/// No surfel lies on both sides of the wall.
TEST(Surfels, EndAtWalls) {
    for (const TwoRooms& rooms : rooms()) {
        for (const double edge : {0.05, 0.17, 0.5}) {
            SCOPED_TRACE(rooms.name + ", " + std::to_string(edge));
            const Surfels surfels(rooms.mesh, edge, Execution{});
            std::vector<char> dark(surfels.size(), 0), light(surfels.size(), 0);
            for (const SurfacePoint& x : even_points(rooms.mesh, 20000, RandomStream(7, "places"))) {
                const Vec3 p = x.position + 1e-7 * x.normal;
                const Vec3 wall_side = p.cwiseMin(Vec3(2, 1, 1)).cwiseMax(Vec3::Zero());
                if ((wall_side - p).norm() > 1e-6) {
                    continue; // of a wall, outside of the room
                }
                (rooms.is_dark(p) ? dark : light)[surfels.at(x.face, x.u, x.v)] = 1;
            }
            std::size_t both = 0;
            for (std::size_t s = 0; s < surfels.size(); ++s) {
                both += dark[s] != 0 && light[s] != 0 ? 1 : 0;
            }
            EXPECT_EQ(both, 0U) << "of " << surfels.size();
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Bases, LightLeaks,
                         testing::Values("normalized-radial", "shepard", "moving-least-squares", "radial"),
                         [](const auto& which) {
                             std::string name = which.param;
                             std::erase(name, '-');
                             return name;
                         });

} // namespace
} // namespace difusa::leaks_test
