// A lit and a dark room over one floor: walls that stand on it by all kinds of feet let no light through.
#include "support/sanitized.h"

#include <difusa/bake.h>
#include <difusa/mesh/surface_sampling.h>

#include <support/wall_feet.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

namespace difusa::wall_feet_test {
namespace {

using namespace feet;

struct Measured {
    double dark = 0.0; ///< the largest irradiance
    double lit = 0.0;  ///< the mean
    SurfacePoint worst;
};

/// At output vertices and random places.
Measured measure(const TwoRooms& rooms, const BakeResult& result) {
    Measured found;
    const Mesh& mesh = result.scene->mesh;
    std::size_t count = 0;
    const auto see = [&](const SurfacePoint& x, double H) {
        // A step off the surface tells the sides of a wall apart. What is on the line of a wall is on neither side, and
        // what the wall covers is no room's.
        const Vec3& n = mesh.normals[x.face];
        const Vec3 inside = 0.999 * x.position + 0.001 * mesh.at(x.face, 1.0 / 3.0, 1.0 / 3.0).position;
        const Vec3 off = 1e-4 * (n.z() > 0.1 ? Vec3(0, 0, 1) : n), p = x.position + off;
        bool dark = rooms.is_dark(inside + off);
        for (int axis = 0; axis < 3; ++axis) {
            const Vec3 step = 5e-5 * Vec3::Unit(axis);
            dark = dark && rooms.is_dark(p + step) && rooms.is_dark(p - step);
        }
        if (dark && H > found.dark) {
            found.dark = H;
            found.worst = x;
        }
        if (!dark && p.x() < 0.9) {
            found.lit += H;
            ++count;
        }
    };
    const std::vector<SurfacePoint> x = even_points(mesh, 2000, RandomStream(3, "places"));
    const PointValues values = result.field().at(x, 0, 5, "places", Execution{});
    for (std::size_t i = 0; i < x.size(); ++i) {
        see(x[i], values.H(static_cast<Eigen::Index>(i), 0));
    }
    found.lit /= static_cast<double>(count);
    for (std::size_t v = 0; v < result.mesh.vertices.size(); ++v) {
        if (result.mesh.vertices[v].position.x() >= 0.9) {
            see(result.mesh.vertices[v], result.output.H(static_cast<Eigen::Index>(v), 0));
        }
    }
    return found;
}

Scene scene_of_rooms(const Mesh& mesh) {
    Scene scene = lit::scene_of(mesh, 0.7);
    scene.materials.resize(2, scene.materials[0]);
    scene.materials[1].emission = Rgb::Ones();
    return scene;
}

/// Names of `wall_feet`, in order. Every process of tests registers all of them: not the time to make the meshes.
constexpr std::array<const char*, 13> feet_names{"rounded foot",
                                                 "rounded foot on a finely cut floor",
                                                 "bevelled foot",
                                                 "wall beside a carpet",
                                                 "wall on the edge of a carpet",
                                                 "wall behind skirting boards",
                                                 "boards with lap joints",
                                                 "panels with a lap joint",
                                                 "wall that crosses rough ground",
                                                 "wall that follows rough ground",
                                                 "bevelled wall sunk into rough ground",
                                                 "partition rounded into a rounded room",
                                                 "wall on a finely cut floor"};

class WallFeet : public testing::TestWithParam<std::size_t> {};

std::string name_of(std::size_t which) {
    std::string name = feet_names[which];
    std::replace(name.begin(), name.end(), ' ', '_');
    return name;
}

/// Feet of a third of the spacing and far below it, coarse and fine sites.
TEST_P(WallFeet, LetNoLightThrough) {
    struct Case {
        double size, spacing;
        const char* basis;
    };
    std::vector<Case> cases{{0.004, 0.23, "moving-least-squares"}};
    if (!test::sanitized()) { // the same code, met more often
        cases.insert(
            cases.end(),
            {{0.004, 0.23, "shepard"}, {0.004, 0.1, "moving-least-squares"}, {0.03, 0.23, "normalized-radial"}});
    }
    for (const Case& each : cases) {
        const std::vector<TwoRooms> all = wall_feet(each.size);
        ASSERT_EQ(all.size(), feet_names.size());
        const TwoRooms& rooms = all[GetParam()];
        ASSERT_EQ(rooms.name, feet_names[GetParam()]);
        SCOPED_TRACE(rooms.name + " of " + std::to_string(each.size) + ", " + each.basis + ", spacing " +
                     std::to_string(each.spacing));
        BakeOptions options = lit::quick(each.spacing, 32);
        options.basis = each.basis;
        options.every_surface = true;
        const Measured found = measure(rooms, lit::baked(scene_of_rooms(rooms.mesh), options));
        EXPECT_LE(found.dark, 1e-4 * found.lit)
            << "at " << found.worst.position.transpose() << " on face " << found.worst.face;
        EXPECT_GT(found.lit, 0.01);
    }
}

INSTANTIATE_TEST_SUITE_P(Scenes, WallFeet, testing::Range<std::size_t>(0, feet_names.size()),
                         [](const auto& which) { return name_of(which.param); });

} // namespace
} // namespace difusa::wall_feet_test
