// Light adds up: the whole is the sum of its groups, whether or not they are kept apart.
#include <difusa/bake.h>
#include <difusa/import/shapes.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/scene/sky_dome.h>

#include <support/lit_scenes.h>

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace difusa::light_sums_test {
namespace {

using namespace lit;

/// Materials: 0 the room, from 1 on four lamps in pairs.
struct LitRoom {
    std::string name;
    Scene scene;
};

/// A room with a window in its ceiling, a table on its floor and four lamps below the ceiling.
Scene room() {
    Mesh mesh = rectangle(Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 2, 0));
    add(mesh, rectangle(Vec3(0, 0, 0), Vec3(0, 0, 1.5), Vec3(2, 0, 0)), 0);
    add(mesh, rectangle(Vec3(0, 0, 0), Vec3(0, 2, 0), Vec3(0, 0, 1.5)), 0);
    add(mesh, rectangle(Vec3(0, 2, 0), Vec3(2, 0, 0), Vec3(0, 0, 1.5)), 0);
    add(mesh, rectangle(Vec3(2, 0, 0), Vec3(0, 0, 1.5), Vec3(0, 2, 0)), 0);
    const double a = 0.8, b = 1.2; // the window is [a, b]²
    for (const auto& [x, y, u, v] : {std::array{0.0, 0.0, 2.0, a}, std::array{0.0, b, 2.0, 2.0},
                                     std::array{0.0, a, a, b}, std::array{b, a, 2.0, b}}) {
        add(mesh, rectangle(Vec3(x, y, 1.5), Vec3(0, v - y, 0), Vec3(u - x, 0, 0)), 0); // facing down
    }
    add(mesh, plain_box(Vec3(0.9, 0.5, 0.3), Vec3(1.3, 1.5, 0.4), 1, Front::outside), 0);
    for (Index lamp = 0; lamp < 4; ++lamp) {
        const double x = lamp % 2 == 0 ? 0.3 : 1.5, y = lamp < 2 ? 0.3 : 1.5;
        add(mesh, rectangle(Vec3(x, y, 1.4), Vec3(0, 0.2, 0), Vec3(0.2, 0, 0)), lamp + 1);
    }
    Scene scene = scene_of(std::move(mesh), 0.6);
    scene.materials.resize(5, scene.materials[0]);
    scene.materials[0].reflectance = Rgb(0.7, 0.5, 0.6);
    for (std::size_t m = 1; m < 5; ++m) {
        scene.materials[m].name = "lamp " + std::to_string(m);
    }
    return scene;
}

std::vector<LitRoom> rooms() {
    std::vector<LitRoom> all;
    const auto next = [&](const std::string& name) -> Scene& {
        all.push_back({name, room()});
        return all.back().scene;
    };
    Scene& lamps = next("area lights in pairs, in the penumbra of a table");
    for (std::size_t m = 1; m < 5; ++m) {
        lamps.materials[m].emission = Rgb(m == 1 ? 90.0 : 10.0, 5.0 * static_cast<double>(m), 3.0);
        lamps.materials[m].light_group = m < 3 ? "left" : "right";
    }
    Scene& sun = next("the sun through a window, and a faint point light");
    sun.suns = {{Vec3(0.2, 0.3, 1.0).normalized(), Rgb(1000, 900, 700), "noon"}};
    sun.point_lights = {{Vec3(0.3, 1.6, 1.0), Rgb::Constant(0.1)}};
    Scene& everything = next("everything");
    everything.materials[1].emission = Rgb(20, 10, 5);
    everything.materials[2].emission = Rgb(5, 10, 20);
    everything.materials[3].emission = Rgb(1, 1, 1);
    everything.materials[3].emission_pattern = [](const Vec3& x) { return 1.0 + x.y(); };
    everything.suns = {{Vec3(0.2, 0.3, 1.0).normalized(), Rgb(100, 90, 70)},
                       {Vec3(-0.2, 0.1, 1.0).normalized(), Rgb(10, 20, 30)},
                       {Vec3(0.1, -0.3, 1.0).normalized(), Rgb(3, 2, 1), "evening"}};
    PointLight spot;
    spot.position = Vec3(1.5, 1.0, 1.3);
    spot.intensity = Rgb(3, 4, 5);
    spot.cos_inner = 0.95;
    spot.cos_outer = 0.8;
    everything.point_lights = {spot, {Vec3(0.3, 1.6, 1.0), Rgb(1, 2, 3)}};
    everything.sky = Rgb(2, 3, 4);
    everything.dome = std::make_shared<GradientSky>(Rgb(1, 2, 3), Rgb(3, 2, 1), Rgb::Zero(), Vec3::UnitZ());
    Scene& sky = next("a sky through a window, and a lamp");
    sky.sky = Rgb(5, 6, 7);
    sky.materials[4].emission = Rgb(2, 2, 2);
    return all;
}

/// Solved to rounding.
BakeOptions exact(const std::string& basis, const std::string& projection) {
    BakeOptions options = quick(0.25, 64);
    options.basis = basis;
    options.projection = projection;
    options.solve.tolerance = 1e-14;
    return options;
}

/// Relative to the brightest.
double difference(const Values& a, const Values& b) {
    return (a - b).cwiseAbs().maxCoeff() / b.cwiseAbs().maxCoeff();
}

void expect_sum(const PointValues& values, std::size_t groups) {
    ASSERT_EQ(values.groups.size(), groups);
    Values B = Values::Zero(values.B.rows(), values.B.cols()), H = B;
    for (const GroupValues& group : values.groups) {
        B += group.B;
        H += group.H;
        EXPECT_GT(group.B.maxCoeff(), 0.0) << group.name;
    }
    EXPECT_LT(difference(B, values.B), 1e-12);
    EXPECT_LT(difference(H, values.H), 1e-12);
    EXPECT_LT(difference(values.H_direct + values.H_indirect, values.H), 1e-12);
}

void expect_same(const PointValues& a, const PointValues& b) {
    EXPECT_LT(difference(a.B, b.B), 1e-12);
    EXPECT_LT(difference(a.H, b.H), 1e-12);
    EXPECT_LT(difference(a.H_direct, b.H_direct), 1e-12);
    EXPECT_LT(difference(a.H_indirect, b.H_indirect), 1e-12);
    EXPECT_EQ(a.E, b.E);
    EXPECT_EQ(a.rho, b.rho);
    EXPECT_TRUE(b.groups.empty());
}

class LightSums : public testing::TestWithParam<std::pair<std::string, std::string>> {};

/// Every solution is within 1e-14 / (1 - 0.7) of its source's brightest.
TEST_P(LightSums, TheWholeIsTheSumOfItsGroupsAndNeedsNone) {
    const auto& [basis, projection] = GetParam();
    const std::vector<std::size_t> groups{2, 2, 8, 2};
    std::size_t number = 0;
    for (const auto& [name, scene] : rooms()) {
        SCOPED_TRACE(name);
        for (const std::size_t final_gather : {0, 32}) {
            BakeOptions options = exact(basis, projection);
            options.final_gather = final_gather;
            const BakeResult whole = baked(scene, options);
            options.light_groups = true;
            const BakeResult apart = baked(scene, options);
            EXPECT_EQ(whole.channels, apart.channels);
            EXPECT_EQ(whole.sites->size(), apart.sites->size());
            expect_sum(apart.output, groups[number]);
            expect_same(apart.output, whole.output);
            EXPECT_TRUE(whole.solution.energy.absorbed.isApprox(apart.solution.energy.absorbed, 1e-12));
            EXPECT_TRUE(whole.solution.energy.from_lights.isApprox(apart.solution.energy.from_lights, 1e-12));
            if (final_gather == 0) {
                EXPECT_LT(
                    difference(sum_of_parts(apart.solution.irradiance, apart.channels), whole.solution.irradiance),
                    1e-12);
                const std::vector<SurfacePoint> x = even_points(scene.mesh, 500, RandomStream(4, "anywhere"));
                const PointValues a = apart.field().at(x, 0, 2, "anywhere", Execution{}),
                                  b = whole.field().at(x, 0, 2, "anywhere", Execution{});
                expect_sum(a, groups[number]);
                expect_same(a, b);
            }
        }
        ++number;
    }
}

/// The limits of the evaluated coefficients are at work: without them the field is another.
TEST(LightSums, TheLimiterIsActive) {
    const Scene scene = rooms()[1].scene;
    const BakeResult limited = baked(scene, exact("normalized-radial", "corrected"));
    LightingOptions how{all_lights(*limited.scene)};
    how.solve = limited.options.solve;
    how.limit = false;
    const Solution free = limited.system->solve(limited.scene, how, Execution{});
    EXPECT_GT(difference(free.field->parts().smooth, limited.field().parts().smooth), 1e-6);
}

/// Which places are bright, where light is sampled more: so they are in the room in the sun.
TEST(LightSums, SomePlacesAreSmallAndBright) {
    const Scene scene = rooms()[1].scene;
    const BakeResult result = baked(scene, exact("normalized-radial", ""));
    ASSERT_TRUE(result.field().parts().bright);
    EXPECT_GT(result.field().parts().bright->places(64), 0U);
}

INSTANTIATE_TEST_SUITE_P(Bases, LightSums,
                         testing::Values(std::pair("normalized-radial", "corrected"), std::pair("shepard", "natural"),
                                         std::pair("moving-least-squares", "galerkin"),
                                         std::pair("normalized-radial", "natural")),
                         [](const auto& which) {
                             std::string name = which.param.first + "_" + which.param.second;
                             std::replace(name.begin(), name.end(), '-', '_');
                             return name;
                         });

} // namespace
} // namespace difusa::light_sums_test
