// Which parts of a scene are inside out, by what light meets.
#include <difusa/bake.h>
#include <difusa/core/error.h>
#include <difusa/lighting/inside_out.h>
#include <difusa/rays/brute_force.h>

#include <scratch_directory.h>
#include <support/plugins.h>
#include <support/rooms.h>
#include <support/sited.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace difusa::inside_out_test {
namespace {

using testing::HasSubstr;

Mesh cube_at(const Vec3& low, double size, bool inward) {
    return test::moved(test::box(size, 1, inward), 1.0, low);
}

Scene with_sky(Mesh mesh) {
    Scene scene = test::uniform_scene(std::move(mesh), 0.5, 0.0);
    scene.sky = Rgb::Ones();
    return scene;
}

Scene with_lamp(Mesh mesh, const Vec3& position) {
    Scene scene = test::uniform_scene(std::move(mesh), 0.5, 0.0);
    PointLight lamp;
    lamp.position = position;
    lamp.intensity = Rgb::Ones();
    scene.point_lights.push_back(lamp);
    return scene;
}

/// Makes the triangles from `first` to before `last` emit.
Scene with_emitter(Mesh mesh, Index first, Index last) {
    Scene scene = test::uniform_scene(std::move(mesh), 0.5, 0.0);
    Material lamp;
    lamp.emission = Rgb::Ones();
    scene.materials.push_back(lamp);
    for (Index t = first; t < last; ++t) {
        scene.mesh.material[t] = static_cast<Index>(scene.materials.size() - 1);
    }
    return scene;
}

FrontVerdict judge(const Scene& scene, const std::optional<Camera>& camera = {}) {
    BruteForceVisibility engine;
    engine.build(scene.mesh);
    return judge_fronts(scene, camera, engine, 1, Execution{});
}

/// "part:fault" of each.
std::vector<std::string> faults(const Scene& scene, const std::optional<Camera>& camera = {}) {
    std::vector<std::string> found;
    for (const auto& [part, fault] : judge(scene, camera).faults) {
        found.push_back(std::to_string(part) + (fault == FrontFault::inside_out  ? ":inside out"
                                                : fault == FrontFault::leaky     ? ":leaky"
                                                : fault == FrontFault::dark_room ? ":dark room"
                                                                                 : ":shut light"));
    }
    return found;
}

using Faults = std::vector<std::string>;

TEST(InsideOut, PartsAreConnectedThroughCornersAndHaveSignedVolumes) {
    const Mesh two = test::together(cube_at({5, 6, 7}, 2.0, false), cube_at({-1, 0, 0}, 1.0, true));
    const FrontVerdict verdict = judge(with_sky(test::together(two, test::grid(2, 2))));
    ASSERT_EQ(verdict.parts.size(), 3U);
    EXPECT_NEAR(verdict.parts[0].volume, 8.0, 1e-12);
    EXPECT_NEAR(verdict.parts[1].volume, -1.0, 1e-12);
    EXPECT_EQ(verdict.parts[2].volume, 0.0);
    EXPECT_EQ(verdict.parts[1].triangles.front(), 12U);
    EXPECT_EQ(verdict.parts[1].triangles.size(), 12U);
}

TEST(InsideOut, AnObjectUnderTheSky) {
    EXPECT_EQ(faults(with_sky(test::icosphere(2))), Faults());
    EXPECT_EQ(faults(with_sky(test::icosphere(2, 1.0, true))), Faults{"0:inside out"});
    // One of two, and either inside the other's bounding box or not.
    for (const Vec3& low : {Vec3(3, 0, 0), Vec3(-0.9, -0.9, 0.8)}) {
        EXPECT_EQ(faults(with_sky(test::together(test::icosphere(2), cube_at(low, 0.1, true)))),
                  Faults{"1:inside out"});
    }
}

TEST(InsideOut, ARoomLitFromWithinStaysAsItIs) {
    EXPECT_EQ(faults(with_lamp(test::box(1.0, 2, true), {0.5, 0.5, 0.8})), Faults());
    EXPECT_EQ(faults(with_emitter(test::box(1.0, 2, true), 0, 4)), Faults());
    EXPECT_EQ(faults(with_emitter(test::room_with_block(), 12, 14)), Faults());
    // Even where the sky shines on its back, and where only the camera is inside.
    Scene lit = with_lamp(test::box(1.0, 2, true), {0.5, 0.5, 0.8});
    lit.sky = Rgb::Ones();
    EXPECT_EQ(faults(lit), Faults());
    const Camera camera{Vec3(0.3, 0.3, 0.3), Vec3::UnitX(), Vec3::UnitZ(), 0.7};
    EXPECT_EQ(faults(with_sky(test::box(1.0, 2, true)), camera), Faults());
}

TEST(InsideOut, WhatIsExactlyInThePlaneOfAFaceIsOnNeitherOfItsSides) {
    // Corners whose means round to either side of the plane: the lamp, the sun, or the camera, must not be seen from
    // the fronts, which are shut in, or the cube would pass for a room.
    const double side = 1.0 / 3.0;
    const Mesh block = cube_at({0.4, 0.4, 0.1}, side, true);
    const Vec3 over = Vec3(0.4 + side, 0.4 + side, 0.9);
    const Mesh both = test::together(test::box(1.0, 2, true), block);
    EXPECT_EQ(faults(with_lamp(both, over)), Faults{"1:inside out"});
    EXPECT_EQ(faults(with_lamp(block, over)), Faults{"0:inside out"});
    EXPECT_EQ(faults(with_sky(block), Camera{over, -Vec3::UnitZ(), Vec3::UnitX(), 0.7}), Faults{"0:inside out"});
}

TEST(InsideOut, ARoomWithItsFrontsOutsideIsToldByTheLightInIt) {
    const Mesh wrong = test::together(test::box(1.0, 2, false), cube_at({0.2, 0.2, 0}, 0.2, false));
    EXPECT_EQ(faults(with_lamp(wrong, {0.5, 0.5, 0.8})), Faults{"0:inside out"});
    const Camera camera{Vec3(0.6, 0.6, 0.3), Vec3::UnitX(), Vec3::UnitZ(), 0.7};
    EXPECT_EQ(faults(with_sky(wrong), camera), Faults{"0:inside out"});
    // With a sky outside, too, it may be a lamp in its shade.
    Scene both = with_lamp(wrong, {0.5, 0.5, 0.8});
    both.sky = Rgb::Ones();
    EXPECT_EQ(faults(both), Faults{"0:shut light"});
}

TEST(InsideOut, WhatStandsInAnInsideOutRoomIsJudgedByTheLightThatThenFalls) {
    // All of the room and its block turned over, as an exporter does it: only the room's own ceiling emits.
    Mesh room = test::together(test::box(1.0, 1, false), cube_at({0.3, 0.3, 0.1}, 0.2, true));
    EXPECT_EQ(faults(with_emitter(room, 10, 12)), (Faults{"0:inside out", "1:inside out"}));
    room = test::together(test::box(1.0, 1, false), cube_at({0.3, 0.3, 0.1}, 0.2, false));
    EXPECT_EQ(faults(with_emitter(room, 10, 12)), Faults{"0:inside out"});
}

TEST(InsideOut, ACupboardThatIsOpenToTheRoomIsNoFault) {
    Mesh cupboard = cube_at({0.1, 0.1, 0.1}, 0.3, false);
    const std::vector<std::array<Index, 3>> sides(cupboard.triangles.begin() + 2, cupboard.triangles.end());
    cupboard = test::make_mesh(cupboard.points, sides);
    const Mesh room = test::together(test::box(1.0, 1, true), cupboard);
    const Camera camera{Vec3(0.05, 0.3, 0.3), Vec3::UnitX(), Vec3::UnitZ(), 0.7}; // looks in
    EXPECT_EQ(faults(with_lamp(room, {0.05, 0.2, 0.2}), camera), Faults());
}

TEST(InsideOut, ACavityIsNoFault) {
    EXPECT_EQ(faults(with_sky(test::together(test::icosphere(2), test::icosphere(2, 0.9, true)))), Faults());
}

TEST(InsideOut, DoubtfulPartsAreNamedAndLeft) {
    // Furniture, but no light.
    EXPECT_EQ(faults(with_sky(test::room_with_block())), Faults{"0:dark room"});
    // A hole of 1/320 of the surface.
    Mesh ball = test::icosphere(2, 1.0, true);
    std::vector<std::array<Index, 3>> triangles(ball.triangles.begin() + 1, ball.triangles.end());
    EXPECT_EQ(faults(with_sky(test::make_mesh(ball.points, triangles))), Faults{"0:leaky"});
    // A window, with a share of 1/6.
    Mesh room = test::box(1.0, 1, true);
    triangles.assign(room.triangles.begin() + 2, room.triangles.end());
    EXPECT_EQ(faults(with_sky(test::make_mesh(room.points, triangles))), Faults());
}

TEST(InsideOut, OpenSheetsHaveNoInside) {
    EXPECT_EQ(faults(with_sky(test::grid(3, 3, 1.0, 1.0, true))), Faults());
    EXPECT_EQ(faults(with_sky(test::mobius(20))), Faults());
}

/// The unit cube as an OFF file, outward or inward.
std::string cube_off(bool inward) {
    std::string text = "OFF\n8 6 0\n";
    for (int i = 0; i < 8; ++i) {
        text += std::to_string(i & 1) + " " + std::to_string((i >> 1) & 1) + " " + std::to_string(i >> 2) + "\n";
    }
    const int quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    for (const auto& q : quads) {
        text += "4";
        for (int k = 0; k < 4; ++k) {
            text += " " + std::to_string(q[inward ? 3 - k : k]);
        }
        text += "\n";
    }
    return text;
}

BakeResult baked(const std::filesystem::path& file, const std::string& flip) {
    BakeOptions options;
    options.sites = 60;
    options.rays = 32;
    options.error_points = 0;
    options.flip = flip;
    return bake(test::registry(), file, options, Execution{});
}

TEST(InsideOut, ABakeTurnsItOverAndSaysSo) {
    const test::ScratchDirectory folder;
    std::ofstream(folder / "out.off") << cube_off(false);
    std::ofstream(folder / "in.off") << cube_off(true);
    const BakeResult right = baked(folder / "out.off", "auto"), mended = baked(folder / "in.off", "auto");
    // No point of a cube sees another: its irradiance is that of the sky.
    EXPECT_LT((right.output.H.array() - 1.0).abs().maxCoeff(), 1e-9);
    EXPECT_LT((mended.output.H.array() - 1.0).abs().maxCoeff(), 1e-9);
    for (const Finding& finding : right.diagnosis.findings) {
        EXPECT_NE(finding.code, "inside-out-parts");
    }
    const Finding& finding = mended.diagnosis.findings.back();
    EXPECT_EQ(finding.code, "inside-out-parts");
    EXPECT_TRUE(finding.repaired);
    EXPECT_EQ(finding.message(),
              "1 connected part inside out: turned over (12 triangles from face 0 (line 11) on, near "
              "(0, 0, 0))");
    EXPECT_THAT(mended.journal.notes(), testing::Not(testing::Contains(HasSubstr("turned over"))));

    EXPECT_THROW(baked(folder / "in.off", "none"), InputError); // it is dark
    const BakeResult all = baked(folder / "in.off", "all");
    EXPECT_LT((all.output.H.array() - 1.0).abs().maxCoeff(), 1e-9);
    EXPECT_THAT(all.journal.notes(), testing::Contains(HasSubstr("--flip all")));
    EXPECT_THROW(baked(folder / "in.off", "some"), UsageError);

    std::ofstream(folder / "scene.json") << R"({"difusa_scene": 1, "meshes": [{"file": "in.off", "flip": true}]})";
    const BakeResult scene = baked(folder / "scene.json", "none");
    EXPECT_LT((scene.output.H.array() - 1.0).abs().maxCoeff(), 1e-9);
}

TEST(InsideOut, ASceneOfAProgramIsLeftAlone) {
    BakeOptions options;
    options.sites = 60;
    options.rays = 32;
    options.error_points = 0;
    const Scene room = with_sky(test::box(1.0, 1, true));
    EXPECT_THROW(bake(test::registry(), room, "a dark room", options, Execution{}), InputError);
    options.flip = "all";
    EXPECT_GT(bake(test::registry(), room, "a box", options, Execution{}).output.H.minCoeff(), 0.99);
}

} // namespace
} // namespace difusa::inside_out_test
