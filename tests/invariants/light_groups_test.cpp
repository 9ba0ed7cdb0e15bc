// Light groups add up to the whole.
#include <difusa/bake.h>
#include <difusa/import/shapes.h>
#include <difusa/scene/light_groups.h>

#include <support/lit_scenes.h>

#include <gtest/gtest.h>

namespace difusa::light_groups_test {
namespace {

using namespace lit;

/// A room with a lamp, a sun, a point light and a sky: each group is what its lights alone would give, as far as both
/// bakes know their own error (limits and samples on surfels follow the total light), and the groups add up to the
/// whole.
TEST(LightGroups, AddUpToTheWhole) {
    Mesh mesh = rectangle(Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 2, 0));
    add(mesh, rectangle(Vec3(0, 2, 0), Vec3(2, 0, 0), Vec3(0, 0, 2)), 0);
    add(mesh, rectangle(Vec3(0.5, 0.5, 1.5), Vec3(0, 0.2, 0), Vec3(0.2, 0, 0)), 1);
    Scene scene = scene_of(mesh, 0.6);
    scene.materials.resize(2);
    scene.materials[1].name = "lamp";
    scene.materials[1].emission = Rgb(10, 20, 30);
    scene.suns = {{Vec3(0, -1, 2).normalized(), Rgb(3, 2, 1), "noon"}};
    scene.point_lights = {{Vec3(1, 1, 1), Rgb(1, 1, 2)}};
    scene.sky = Rgb(0.5, 0.6, 0.7);
    BakeOptions options = quick(0.3);
    options.light_groups = true;
    options.error_points = 512;
    const BakeResult whole = baked(scene, options);
    ASSERT_EQ(whole.output.groups.size(), 4U);
    const std::vector<std::string> names{"lamp", "noon", "point", "sky"};
    Values B = Values::Zero(whole.output.B.rows(), 3), H = B;
    for (std::size_t g = 0; g < 4; ++g) {
        EXPECT_EQ(whole.output.groups[g].name, names[g]);
        B += whole.output.groups[g].B;
        H += whole.output.groups[g].H;
        Scene alone = scene;
        if (g != 0) {
            alone.materials[1].emission.setZero();
        }
        if (g != 1) {
            alone.suns.clear();
        }
        if (g != 2) {
            alone.point_lights.clear();
        }
        options.light_groups = false;
        options.sky = g == 3 ? scene.sky : Rgb(Rgb::Zero());
        const BakeResult one = baked(alone, options);
        ASSERT_EQ(one.output.B.rows(), B.rows());
        const double rms = std::sqrt((one.output.B - whole.output.groups[g].B).rowwise().squaredNorm().mean());
        EXPECT_LT(rms, one.error->bound) << names[g];
    }
    const double rounding = 64 * 0x1p-53 * whole.output.B.maxCoeff();
    EXPECT_LT((B - whole.output.B).cwiseAbs().maxCoeff(), rounding);
    EXPECT_LT((H - whole.output.H).cwiseAbs().maxCoeff(), rounding);
    // And without groups it is the same solution: the solver treats other columns, and area lights draw alike.
    options.light_groups = false;
    options.sky.reset();
    const BakeResult together = baked(scene, options);
    EXPECT_LT((together.output.H - whole.output.H).cwiseAbs().maxCoeff(),
              2.0 * 1e-6 / (1.0 - 0.6) * together.solution.direct.maxCoeff());
}

TEST(LightGroups, NamesAndOrder) {
    Scene scene = scene_of(rectangle(Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 2, 0), 2, 2), 0.5);
    scene.materials.resize(3);
    scene.materials[1] = {"a", Rgb::Zero(), Rgb::Ones()};
    scene.materials[2] = {"unused", Rgb::Zero(), Rgb::Ones()};
    scene.mesh.material[0] = 1;
    PointLight spot;
    spot.intensity = Rgb::Ones();
    spot.cos_outer = 0.5;
    spot.cos_inner = 0.6;
    scene.point_lights = {
        {Vec3::Zero(), Rgb::Ones()}, spot, {Vec3::Zero(), Rgb::Zero(), -Vec3::UnitZ(), -1, -1, "dark"}};
    scene.suns = {{Vec3::UnitZ(), Rgb::Ones(), "a"}, {Vec3::UnitZ(), Rgb::Ones()}};
    const LightSets groups = light_groups(scene);
    EXPECT_EQ(groups.names, (std::vector<std::string>{"a", "sun", "point", "spot"}));
    EXPECT_EQ(groups.material[1], 0U);
    EXPECT_EQ(groups.sun, (std::vector<Index>{0, 1}));
    ASSERT_EQ(groups.point.size(), 3U);
    EXPECT_EQ(groups.point[0], 2U);
    EXPECT_EQ(groups.point[1], 3U);
}

/// Names are as files can hold them, and then no two groups have the same.
TEST(LightGroups, NamesThatFilesHold) {
    Scene scene = scene_of(rectangle(Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 2, 0), 2, 2), 0.5);
    const Vec3 up = Vec3::UnitZ();
    for (const char* name : {"a\x01", "a\x02", "a\n", "a_", "\xff", "\xed\xa0\x80", "ρ & <\"x\">"}) {
        scene.suns.push_back({up, Rgb::Ones(), name});
    }
    EXPECT_EQ(light_groups(scene).names, (std::vector<std::string>{"a_", "_", "___", "ρ & <\"x\">"}));
}

} // namespace
} // namespace difusa::light_groups_test
