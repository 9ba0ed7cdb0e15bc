#include <difusa/scene/light_groups.h>

#include <support/sited.h>

#include <gtest/gtest.h>

#include <meshes.h>

#include <string>
#include <vector>

namespace difusa::light_sets_test {
namespace {

using Names = std::vector<std::string>;
using Sets = std::vector<Index>;

TEST(LightSets, WithoutLightThereIsOneWithoutAName) {
    const Scene dark = test::uniform_scene(test::grid(1, 1), 0.5, 0.0);
    for (const LightSets& sets : {all_lights(dark), light_groups(dark)}) {
        EXPECT_EQ(sets.names, Names{""});
        EXPECT_EQ(sets.count(), 1U);
        EXPECT_EQ(sets.material, Sets{0});
        EXPECT_EQ(sets.sky, 0U);
    }
}

Scene many_lights() {
    Scene scene = test::uniform_scene(test::grid(2, 2), 0.5, 0.0);
    scene.materials.resize(6, scene.materials[0]);
    for (std::size_t m = 1; m < 6; ++m) {
        scene.materials[m].name = "lamp " + std::to_string(m);
        scene.materials[m].emission = Rgb(0, 0, 1);
    }
    scene.materials[2].light_group = "shelf";
    scene.materials[3].light_group = "shelf";
    scene.materials[5].name = "on no face";
    scene.mesh.material = {0, 1, 2, 3, 4, 0, 0, 0};
    scene.suns = {
        {Vec3::UnitZ(), Rgb::Ones()}, {Vec3::UnitZ(), Rgb::Zero(), "out"}, {Vec3::UnitZ(), Rgb::Ones(), "lamp 4"}};
    PointLight point, spot, named;
    point.intensity = spot.intensity = named.intensity = Rgb::Ones();
    spot.cos_outer = 0.5;
    spot.cos_inner = 0.6;
    named.name = "two\nlines";
    scene.point_lights = {point, spot, named, point};
    scene.sky = Rgb::Ones();
    return scene;
}

TEST(LightSets, OneForEachNameInOrder) {
    const LightSets sets = light_groups(many_lights());
    EXPECT_EQ(sets.names, (Names{"lamp 1", "shelf", "lamp 4", "sun", "point", "spot", "two_lines", "sky"}));
    EXPECT_EQ(Sets(sets.material.begin() + 1, sets.material.begin() + 5), (Sets{0, 1, 1, 2}));
    ASSERT_EQ(sets.sun.size(), 3U);
    EXPECT_EQ(sets.sun[0], 3U);
    EXPECT_EQ(sets.sun[2], 2U) << "of the same name as a material";
    EXPECT_EQ(sets.point, (Sets{4, 5, 6, 4}));
    EXPECT_EQ(sets.sky, 7U);
    for (const Sets& numbers : {sets.material, sets.sun, sets.point}) {
        for (const Index set : numbers) {
            EXPECT_LT(set, sets.count());
        }
    }
}

TEST(LightSets, AllLightsAreOne) {
    const Scene scene = many_lights();
    const LightSets sets = all_lights(scene);
    EXPECT_EQ(sets.names, Names{""});
    EXPECT_EQ(sets.material, Sets(6, 0));
    EXPECT_EQ(sets.sun, Sets(3, 0));
    EXPECT_EQ(sets.point, Sets(4, 0));
    EXPECT_EQ(sets.sky, 0U);
}

} // namespace
} // namespace difusa::light_sets_test
