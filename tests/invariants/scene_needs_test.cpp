// What a scene does not need is not computed, and what a bake says of a scene.
#include <difusa/bake.h>
#include <difusa/import/shapes.h>

#include <support/lit_scenes.h>
#include <support/rooms.h>

#include <gtest/gtest.h>

#include <cmath>

namespace difusa::scene_needs_test {
namespace {

using namespace lit;

/// What a scene does not have costs nothing: counted in rays.
TEST(OnlyWhatTheSceneNeeds, AConvexEmptyRoomCastsNoShadowRays) {
    Mesh mesh = plain_box(Vec3::Zero(), Vec3::Ones(), 2, Front::inside);
    ASSERT_TRUE(mesh.convex);
    Scene scene = scene_of(mesh, 0.5);
    scene.materials.resize(2);
    scene.materials[1].emission = Rgb::Ones();
    scene.mesh.material[40] = 1; // of 48: a lamp
    for (const char* transport : {"gather", "pairwise"}) {
        BakeOptions options = quick(0.2);
        options.transport = transport;
        const BakeResult result = baked(scene, options);
        EXPECT_EQ(result.solution.area_lights, 1U);
        EXPECT_EQ(result.journal.count_of("segments"), 0U) << transport;
        EXPECT_EQ(result.journal.count_of("output segments"), 0U);
        EXPECT_EQ(result.channels, 1);
    }
    // A small block in it, and there are rays.
    add(scene.mesh, plain_box(Vec3::Constant(0.4), Vec3::Constant(0.6), 1, Front::outside), 0);
    EXPECT_FALSE(scene.mesh.convex);
    EXPECT_GT(baked(scene, quick(0.2)).journal.count_of("segments"), 0U);
}

TEST(OnlyWhatTheSceneNeeds, WithoutSharpLightsThereAreNoShadowRays) {
    Scene scene = scene_of(test::room_with_block(), 0.5);
    scene.materials[0].emission = Rgb::Ones();
    const BakeResult result = baked(scene, quick(0.2));
    EXPECT_EQ(result.journal.count_of("segments"), 0U);
    EXPECT_EQ(result.journal.count_of("rays"), result.sites->size() * 64);
    const auto saved = [&](const std::string& what) {
        return std::any_of(result.journal.savings().begin(), result.journal.savings().end(),
                           [&](const Saving& saving) { return saving.what == what && saving.amount > 0.0; });
    };
    EXPECT_TRUE(saved("sky"));
    EXPECT_TRUE(saved("two of three channels"));
    EXPECT_TRUE(saved("direct light by shadow rays"));
}

/// The outside of a closed room under no sky sees nothing: it gets no sites, and the inside as many as wanted.
TEST(OnlyWhatTheSceneNeeds, SitesAreNotSpentInTheDark) {
    Mesh mesh = plain_box(Vec3::Zero(), Vec3::Ones(), 2, Front::inside);
    add(mesh, plain_box(Vec3::Constant(-0.1), Vec3::Constant(1.1), 2, Front::outside), 0);
    Scene scene = scene_of(mesh, 0.5);
    scene.materials.resize(2);
    scene.materials[1].emission = Rgb(1, 2, 3);
    scene.mesh.material[40] = 1;
    BakeOptions options = quick(0.0);
    options.sites = 600;
    const BakeResult result = baked(scene, options);
    EXPECT_NEAR(static_cast<double>(result.sites->size()), 600.0, 60.0);
    for (const SurfacePoint& site : result.sites->points) {
        EXPECT_LT(site.face, 48U);
    }
    for (std::size_t v = 0; v < result.mesh.vertices.size(); ++v) {
        const double B = result.output.B(static_cast<Eigen::Index>(v), 0);
        EXPECT_EQ(B == 0.0, result.mesh.vertices[v].face >= 48U);
    }
    // Under a sky the outside has sites too.
    options.sky = Rgb::Ones();
    bool outside = false;
    const BakeResult lit = baked(scene, options);
    for (const SurfacePoint& site : lit.sites->points) {
        outside = outside || site.face >= 48U;
    }
    EXPECT_TRUE(outside);
}

/// A floor that sees nothing but a lamp of a ten thousandth of its size, or less, which no handful of rays meets.
TEST(OnlyWhatTheSceneNeeds, WhatALampLightsIsNotDark) {
    for (const double size : {10.0, 40.0, 400.0}) {
        for (const bool even : {true, false}) {
            Scene scene = scene_of(rectangle(Vec3(-size / 2, -size / 2, 0), Vec3(size, 0, 0), Vec3(0, size, 0)), 0.5);
            scene.materials.resize(2);
            scene.materials[1].emission = Rgb::Constant(100.0);
            if (!even) { // no lamp: left to the rays
                scene.materials[1].emission_pattern = [](const Vec3&) { return 1.0; };
            }
            add(scene.mesh, rectangle(Vec3(0, 0, 3), Vec3(0, 0.3, 0), Vec3(0.3, 0, 0)), 1); // facing down
            BakeOptions options = quick(0.0, 16);
            options.sites = 300;
            const BakeResult result = baked(scene, options);
            EXPECT_NEAR(static_cast<double>(result.sites->size()), 300.0, 60.0) << size;
        }
    }
}

/// A lamp that hangs with its back to the room lights nothing, which is said.
TEST(Bake, SaysWhichEmittersFaceAway) {
    Scene scene = scene_of(plain_box(Vec3::Zero(), Vec3::Ones(), 1, Front::inside), 0.5);
    scene.materials.resize(2);
    scene.materials[1].name = "bulb";
    scene.materials[1].emission = Rgb::Ones();
    add(scene.mesh, rectangle(Vec3(0.4, 0.4, 2), Vec3(0.1, 0, 0), Vec3(0, 0.1, 0)), 1); // above the room, facing up
    scene.point_lights = {{Vec3(0.5, 0.5, 0.5), Rgb::Ones()}};
    const BakeResult result = baked(scene, quick(0.3));
    const bool said =
        std::any_of(result.journal.notes().begin(), result.journal.notes().end(), [](const std::string& note) {
            return note.find("2 emitting triangles light nothing, the first in face 12 (material bulb)") == 0;
        });
    EXPECT_TRUE(said);
    add(scene.mesh, rectangle(Vec3(0.4, 0.4, 0.9), Vec3(0, 0.1, 0), Vec3(0.1, 0, 0)), 1); // in the room, facing down
    scene.point_lights.clear();
    EXPECT_NO_THROW(baked(scene, quick(0.3)));
}

/// Light of lamps that no light reaches has no gather points that tell where it goes: all of it escapes above the room,
/// and all of it is lost on the backs of the crate around the other lamp.
TEST(Bake, KnowsWhereTheLightOfUnlitLampsGoes) {
    Scene scene = scene_of(plain_box(Vec3::Zero(), Vec3::Ones(), 1, Front::inside), 0.5);
    scene.materials.resize(2);
    scene.materials[1].emission = Rgb::Ones();
    scene.point_lights = {{Vec3(0.5, 0.5, 0.9), Rgb::Constant(1e-3)}}; // about as much light as the lamp's
    const double before = baked(scene, quick(0.3)).solution.energy.imbalance[0];
    Scene above = scene;
    add(above.mesh, rectangle(Vec3(0.4, 0.4, 2), Vec3(0.1, 0, 0), Vec3(0, 0.1, 0)), 1);
    const EnergyBalance escaped = baked(above, quick(0.3)).solution.energy;
    EXPECT_NEAR(escaped.escaped[0], 0.01, 1e-15);
    EXPECT_EQ(escaped.blocked[0], 0.0);
    Scene crate = scene;
    add(crate.mesh, plain_box(Vec3::Constant(0.3), Vec3::Constant(0.6), 1, Front::outside), 0);
    add(crate.mesh, rectangle(Vec3(0.4, 0.4, 0.4), Vec3(0.1, 0, 0), Vec3(0, 0.1, 0)), 1);
    const EnergyBalance blocked = baked(crate, quick(0.3)).solution.energy;
    EXPECT_NEAR(blocked.blocked[0], 0.01, 1e-15);
    EXPECT_NEAR(blocked.escaped[0], 0.0, 1e-15);
    for (const EnergyBalance& balance : {escaped, blocked}) {
        EXPECT_NEAR(balance.emitted[0], 0.01, 1e-15);
        EXPECT_LT(std::abs(balance.imbalance[0]), std::abs(before) + 0.01);
    }
}

/// Places that a user lists, off the surface, and the centres of faces: in a furnace the light is known.
TEST(Bake, EvaluatesListedPlacesAndCentres) {
    Scene scene = test::uniform_scene(plain_box(Vec3::Zero(), Vec3::Ones(), 2, Front::inside), 0.5, 1.0);
    add(scene.mesh, plain_box(Vec3::Constant(0.4), Vec3::Constant(0.6), 1, Front::outside), 0);
    BakeOptions options = quick(0.2);
    options.face_centres = true;
    options.snap = true;
    options.at = {{Vec3(0.5, 0.5, -0.01), {}}, {Vec3(0.5, 0.5, 0.39), {}}, {Vec3(0.5, 0.5, 0.39), Vec3::UnitZ()}};
    const BakeResult result = baked(scene, options);
    ASSERT_EQ(result.listed.size(), 3U);
    EXPECT_TRUE(result.listed[0].position.isApprox(Vec3(0.5, 0.5, 0.0)));
    EXPECT_NEAR(result.listed_distance[0], 0.01, 1e-12);
    EXPECT_EQ(result.listed[1].normal, -Vec3::UnitZ()); // the block's bottom
    EXPECT_EQ(result.listed[2].normal, Vec3::UnitZ());  // not the bottom: the block's top
    EXPECT_NEAR(result.listed[2].position.z(), 0.6, 1e-12);
    ASSERT_TRUE(result.centres);
    EXPECT_EQ(result.centres->B.rows(), std::ssize(result.mesh.triangles));
    for (const Values* B : {&result.listed_values.B, &result.centres->B}) {
        EXPECT_LT((B->array() - 2.0).abs().maxCoeff(), 1e-10);
    }
}

} // namespace
} // namespace difusa::scene_needs_test
