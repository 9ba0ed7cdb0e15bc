// Which parts of a scene are inside out, by what light meets.
#include <difusa/bake.h>
#include <difusa/core/error.h>
#include <difusa/lighting/inside_out.h>
#include <difusa/mesh/borders.h>
#include <difusa/rays/brute_force.h>

#include <scratch_directory.h>
#include <support/plugins.h>
#include <support/rooms.h>
#include <support/sited.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <fstream>
#include <numbers>
#include <numeric>
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

/// The faces of a room, 1 by 1 by 1, towards its inside, each a quad with points of its own, with a hole of this width
/// in the middle of the ceiling, which is of four rectangles: their sides end within those of others.
Mesh room_with_hole(double width) {
    const double a = 0.5 - width / 2.0, b = 0.5 + width / 2.0;
    std::vector<std::array<Vec3, 4>> quads{
        {Vec3(0, 0, 0), {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {Vec3(0, 0, 0), {0, 0, 1}, {1, 0, 1}, {1, 0, 0}},
        {Vec3(0, 1, 0), {1, 1, 0}, {1, 1, 1}, {0, 1, 1}}, {Vec3(0, 0, 0), {0, 1, 0}, {0, 1, 1}, {0, 0, 1}},
        {Vec3(1, 0, 0), {1, 0, 1}, {1, 1, 1}, {1, 1, 0}}, {Vec3(0, 0, 1), {0, a, 1}, {1, a, 1}, {1, 0, 1}},
        {Vec3(0, b, 1), {0, 1, 1}, {1, 1, 1}, {1, b, 1}}};
    if (a < b) {
        quads.push_back({Vec3(0, a, 1), {0, b, 1}, {a, b, 1}, {a, a, 1}});
        quads.push_back({Vec3(b, a, 1), {b, b, 1}, {1, b, 1}, {1, a, 1}});
    }
    std::vector<Vec3> points;
    std::vector<std::array<Index, 3>> triangles;
    const auto number = [&](const Vec3& p) {
        const auto found = std::find(points.begin(), points.end(), p);
        const auto index = static_cast<Index>(found - points.begin());
        if (found == points.end()) {
            points.push_back(p);
        }
        return index;
    };
    for (const auto& [p, q, r, s] : quads) {
        triangles.push_back({number(p), number(q), number(r)});
        triangles.push_back({number(p), number(r), number(s)});
    }
    return test::make_mesh(points, triangles);
}

std::vector<Index> all_of(const Mesh& mesh) {
    std::vector<Index> all(mesh.triangles.size());
    std::iota(all.begin(), all.end(), Index{0});
    return all;
}

TEST(InsideOut, WhereSidesEndWithinOthersIsNoBorderUnlessThereIsAHole) {
    EXPECT_FALSE(has_border(test::icosphere(2), all_of(test::icosphere(2))));
    const Mesh two = test::together(test::box(1.0, 2, true), cube_at({3, 0, 0}, 1.0, false));
    EXPECT_FALSE(has_border(two, all_of(two)));
    EXPECT_TRUE(has_border(test::grid(3, 3), all_of(test::grid(3, 3))));
    EXPECT_TRUE(has_border(test::mobius(20), all_of(test::mobius(20))));
    Mesh room = room_with_hole(0.0); // the halves of the ceiling meet along a line that ends within sides of the walls
    EXPECT_FALSE(has_border(room, all_of(room)));
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
    for (Vec3& p : room.points) { // turned, and rounded as in a file
        p = (turn * p).cast<float>().cast<double>();
    }
    room.derive();
    EXPECT_FALSE(has_border(room, all_of(room)));
    for (const double width : {1e-5, 0.001, 0.1}) {
        EXPECT_TRUE(has_border(room_with_hole(width), all_of(room_with_hole(width))));
    }
    // Without one triangle.
    const Mesh ball = test::icosphere(2);
    std::vector<Index> some = all_of(ball);
    some.pop_back();
    EXPECT_TRUE(has_border(ball, some));
}

TEST(InsideOut, APartWithAHoleIsNotTurnedOver) {
    EXPECT_EQ(faults(with_sky(room_with_hole(0.0))), Faults{"0:inside out"});
    // The share of rays that pass the hole is at most 1e-6 or 1e-8: 4096 rays miss it, for nearly every seed.
    for (const double width : {0.001, 0.0001}) {
        EXPECT_EQ(faults(with_sky(room_with_hole(width))), Faults{"0:leaky"});
    }
    // A sun that shines in through it.
    Scene sunny = test::uniform_scene(room_with_hole(0.001), 0.5, 0.0);
    sunny.suns.push_back({Vec3(0.1, 0.2, 1.0).normalized(), Rgb::Ones()});
    EXPECT_EQ(faults(sunny), Faults{"0:leaky"});
    // A hole that another part covers, from outside or from inside.
    for (const double z : {1.01, 0.99}) {
        const Mesh lid = test::moved(test::grid(1, 1), 0.2, {0.4, 0.4, z});
        EXPECT_EQ(faults(with_sky(test::together(room_with_hole(0.0001), lid))),
                  Faults{z > 1.0 ? "0:leaky" : "0:dark room"});
    }
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
