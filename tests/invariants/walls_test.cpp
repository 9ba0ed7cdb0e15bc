// Walls, however thin, between a lit and a dark room.
#include <difusa/bake.h>
#include <difusa/import/shapes.h>
#include <difusa/rays/visibility.h>

#include <support/plugins.h>
#include <support/rooms.h>
#include <support/sited.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace difusa::walls_test {
namespace {

/// Without an estimate of the error.
BakeResult coarsely_baked(Scene scene, double spacing, const std::string& engine) {
    BakeOptions options;
    options.spacing = spacing;
    options.rays = 32;
    options.visibility = engine;
    options.error_points = 0;
    options.solve.tolerance = 1e-12;
    return bake(test::registry(), std::move(scene), "walls", options, Execution{1, nullptr});
}

/// The triangles `which` holds emit 1.
void add_lamp(Scene& scene, double rho, const std::function<bool(const SurfacePoint&)>& which) {
    Material lamp;
    lamp.reflectance = Rgb::Constant(rho);
    lamp.emission = Rgb::Ones();
    const auto number = static_cast<Index>(scene.materials.size());
    scene.materials.push_back(lamp);
    for (Index t = 0; t < scene.mesh.triangles.size(); ++t) {
        if (which(scene.mesh.at(t, 1.0 / 3, 1.0 / 3))) {
            scene.mesh.material[t] = number;
        }
    }
}

/// Inner walls of the box from `low` to `high`.
Mesh chamber(const Vec3& low, const Vec3& high) {
    return test::moved(test::box(Vec3(high - low), 1, true), 1.0, low);
}

TEST(Walls, AWallBetweenALitAndADarkRoomLetsNothingThrough) {
    // The dark room sees no light at all: its irradiance is 0, whatever the wall's thickness.
    for (const std::string& engine : test::plugin_names<Visibility>()) {
        for (const double thickness : {0.1, 1e-3, 1e-6, 1e-9, 1e-12, 0.0}) {
            SCOPED_TRACE(engine + ", thickness " + std::to_string(std::log10(thickness)));
            const double far = 1.0 + thickness;
            Scene scene = test::uniform_scene(
                test::together(chamber({0, 0, 0}, {1, 1, 1}), chamber({far, 0, 0}, {far + 1.0, 1, 1})), 0.7, 0.0);
            add_lamp(scene, 0.5, [](const SurfacePoint& x) { return x.normal.z() < -0.5 && x.position.x() < 1.0; });
            const BakeResult result = coarsely_baked(scene, 0.2, engine);
            double lit = 0.0, dark = 0.0;
            for (std::size_t f = 0; f < result.mesh.triangles.size(); ++f) { // faces 0 to 11 are those of the lit room
                for (const Index v : result.mesh.triangles[f]) {
                    double& room = result.mesh.face[f] < 12 ? lit : dark;
                    room = std::max(room, result.output.H(static_cast<Eigen::Index>(v), 0));
                }
            }
            EXPECT_GT(lit, 0.5);
            EXPECT_EQ(dark, 0.0);
        }
    }
}

// A wall that stands on a floor which runs on beneath it: both sides of the floor are one region, and so are those of
// the ceiling and of the walls along it. No light at all gets into the dark room but through elements that reach there.
TEST(Walls, AWallThatStandsOnAFloorLetsNothingThrough) {
    for (const double thickness : {0.1, 1e-3, 1e-6, 0.0}) {
        SCOPED_TRACE(thickness);
        const double far = 1.0 + thickness;
        const auto side = [](double x, bool looks_up) {
            std::vector<Vec3> points{{x, 0, 0}, {x, 1, 0}, {x, 1, 1}, {x, 0, 1}};
            return looks_up ? test::make_mesh(points, {{0, 1, 2}, {0, 2, 3}})
                            : test::make_mesh(points, {{0, 2, 1}, {0, 3, 2}});
        };
        Mesh rooms = test::together(test::box(Vec3(1.0 + far, 1, 1), 1, true), side(1.0, false));
        rooms = test::together(rooms, side(far, true));
        const auto walls = static_cast<Index>(rooms.triangles.size());
        rooms = test::together(rooms, test::moved(test::grid(1, 1, 0.4, 0.4, true), 1.0, Vec3(0.3, 0.3, 0.99)));
        Scene scene = test::uniform_scene(std::move(rooms), 0.7, 0.0);
        add_lamp(scene, 0.7, [&](const SurfacePoint& x) { return x.face >= walls; });
        const BakeResult result = coarsely_baked(scene, 0.1, "cgal");
        double lit = 0.0, dark = 0.0;
        for (std::size_t v = 0; v < result.mesh.vertices.size(); ++v) {
            const double x = result.mesh.vertices[v].position.x();
            const double H = result.output.H(static_cast<Eigen::Index>(v), 0);
            (x < 1.0 ? lit : dark) = std::max(x < 1.0 ? lit : dark, x < 1.0 || x > far + 1e-7 ? H : 0.0);
        }
        EXPECT_GT(lit, 0.04); // the lamp alone, straight above: about area / (pi distance²) = 0.05
        EXPECT_EQ(dark, 0.0);
    }
}

/// A house without windows on sunlit ground that runs on beneath it: groups of surfels whose exact form factors a point
/// inside uses do not reach out under the wall that it is on. Some groups beyond others' walls did not, either.
class ClosedHouse : public testing::TestWithParam<std::tuple<double, double>> {};

TEST_P(ClosedHouse, GroupsOfSurfelsLetNothingIn) {
    const auto [foot, turn] = GetParam();
    const Eigen::AngleAxisd turned(turn, Vec3(1, 2, 3).normalized());
    Mesh house = test::moved(test::box(Vec3(4, 4, 3), 1, false), 1.0, Vec3(-2, -2, 0));
    house = test::together(house, chamber({-1.8, -1.8, 0.0}, {1.8, 1.8, 2.8}));
    std::erase_if(house.triangles, [&](const auto& triangle) { // no bottoms: the ground is there
        return std::all_of(triangle.begin(), triangle.end(),
                           [&](Index corner) { return house.points[corner].z() == 0.0; });
    });
    Scene scene = test::uniform_scene(
        test::together(rectangle({-10, -10, 0}, {20, 0, 0}, {0, 20, 0}),
                       test::make_mesh(house.points, {house.triangles.begin(), house.triangles.end()})),
        0.5, 0.0);
    for (Vec3& p : scene.mesh.points) {
        p.z() += p.z() == 0.0 && p.head<2>().cwiseAbs().maxCoeff() < 5.0 ? foot : 0.0;
        p = turned * p;
    }
    scene.mesh.derive();
    scene.suns = {Sun{turned * Vec3(1.0, 0.5, 1.0).normalized(), Rgb::Constant(500.0)}};
    scene.sky = Rgb::Constant(100.0);
    BakeOptions options;
    options.sites = 1500;
    options.error_points = 0;
    options.analytic = "always";
    const BakeResult result = bake(test::registry(), std::move(scene), "house", options, Execution{2});
    double inside = 0.0, outside = 0.0;
    for (std::size_t v = 0; v < result.mesh.vertices.size(); ++v) {
        const SurfacePoint& x = result.mesh.vertices[v];
        const Vec3 before = turned.inverse() * Vec3(x.position + 0.01 * x.normal);
        double& most = before.head<2>().cwiseAbs().maxCoeff() < 1.8 && before.z() < 2.8 ? inside : outside;
        most = std::max(most, result.output.H(static_cast<Eigen::Index>(v), 0));
    }
    EXPECT_GT(outside, 300.0);
    EXPECT_LE(inside, 1e-12 * outside);
}

INSTANTIATE_TEST_SUITE_P(FootAndTurn, ClosedHouse,
                         testing::Values(std::tuple(0.0, 0.0), std::tuple(1e-15, 0.0), std::tuple(0.0, 0.3)));

} // namespace
} // namespace difusa::walls_test
