// Glossy surfaces: against the furnace, path tracing, mirrors, and themselves.
#include <difusa/bake/saved_transport.h>
#include <difusa/lighting/direct_light.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/render/camera_rays.h>
#include <difusa/render/picture.h>
#include <difusa/study/gloss_study.h>
#include <difusa/transport/glossy_transport.h>

#include <support/discretised.h>
#include <support/furnace.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace difusa::gloss_test {
namespace {

using Model = LobeShape::Model;

BakeOptions small(std::size_t sites, std::size_t rays, int order = 6) {
    BakeOptions options;
    options.sites = sites;
    options.rays = rays;
    options.directional_order = order;
    options.error_points = 0;
    options.output_spacing = 1.0;
    return options;
}

/// Radiance is the same everywhere and in all directions, of which harmonics of any order know: H = E / (1 - rho -
/// gloss), but for the solver and the series of glossy reflections, of which 1e-9 are left.
TEST(Gloss, TheFurnaceIsExact) {
    for (const LobeShape shape : {LobeShape{Model::phong, 20.0}, LobeShape{Model::ggx, 0.4}}) {
        Scene scene = test::furnace(0.4, 1.0);
        for (Material& material : scene.materials) {
            material.gloss = Gloss{shape, Rgb::Constant(0.3)};
        }
        BakeOptions options = small(300, 64);
        options.solve.tolerance = 1e-12;
        const BakeResult result = test::baked(std::move(scene), options);
        const double expected = 1.0 / 0.3;
        EXPECT_LT((result.output.H.array() - expected).abs().maxCoeff(), 1e-7 * expected);
        EXPECT_LT(result.solution.energy.imbalance.abs().maxCoeff(), 1e-6);
        ASSERT_TRUE(result.glossy);
        EXPECT_GT(result.glossy->reflections, 0U);
    }
}

/// <y, W x> = <Wᵀ y, x>, coloured, with glossy surfaces that see each other.
TEST(Gloss, TheTransposeIsOne) {
    Scene scene = glossy_room({Model::ggx, 0.5}, Rgb(0.6, 0.3, 0.1));
    scene.materials[1].reflectance = Rgb::Constant(0.4);
    scene.materials[1].gloss = Gloss{{Model::phong, 10.0}, Rgb::Constant(0.5)};
    settle_gloss(scene);
    const test::Discretised made(std::move(scene), 0.6, "cgal", "normalized-radial");
    const Execution execution{2, nullptr, nullptr};
    const LightTransport transport =
        with_gloss(made.gathered(64), made.discretisation, made.scene.mesh.glossy, 4, execution);
    ASSERT_NE(glossy_part(*transport.W), nullptr);
    EXPECT_GT(glossy_part(*transport.W)->reflections(), 0U);
    RandomStream stream(1, "vectors");
    Values x(static_cast<Eigen::Index>(transport.W->columns()), 3),
        y(static_cast<Eigen::Index>(transport.W->rows()), 3);
    for (Values* values : {&x, &y}) {
        for (Eigen::Index k = 0; k < values->size(); ++k) {
            values->data()[k] = stream.uniform();
        }
    }
    Values Wx, Wy;
    transport.W->apply(x, Wx, execution);
    transport.W->apply_transpose(y, Wy, execution);
    for (Eigen::Index c = 0; c < 3; ++c) {
        const double here = y.col(c).dot(Wx.col(c)), there = Wy.col(c).dot(x.col(c));
        EXPECT_NEAR(here, there, 1e-10 * std::abs(here));
    }
}

/// With many columns, coefficients are read tile by tile: here 384 KiB, the 49 coefficients of 21 columns of 47 parts.
TEST(Gloss, ManyColumnsAreWhatEachIsAlone) {
    Scene scene = glossy_room({Model::ggx, 0.5}, Rgb(0.6, 0.3, 0.1));
    settle_gloss(scene);
    const test::Discretised made(std::move(scene), 0.6, "cgal", "normalized-radial");
    const LightTransport transport =
        with_gloss(made.gathered(64), made.discretisation, made.scene.mesh.glossy, 6, Execution{2});
    ASSERT_NE(glossy_part(*transport.W), nullptr);
    ASSERT_GT(glossy_part(*transport.W)->rays().surfels().parts().size(), 2 * 47U);
    Values x(static_cast<Eigen::Index>(transport.W->columns()), 21);
    RandomStream stream(1, "vectors");
    for (Eigen::Index k = 0; k < x.size(); ++k) {
        x.data()[k] = stream.uniform();
    }
    Values all, of_threads, one;
    transport.W->apply(x, all, Execution{1});
    transport.W->apply(x, of_threads, Execution{3});
    EXPECT_EQ(all, of_threads);
    for (Eigen::Index c = 0; c < x.cols(); c += 3) {
        transport.W->apply(x.middleCols(c, 3), one, Execution{1});
        // Sums of at most a million numbers in another order.
        EXPECT_LT((one - all.middleCols(c, 3)).cwiseAbs().maxCoeff(), 1e6 * 2.2e-16 * one.cwiseAbs().maxCoeff());
    }
}

/// The walls of a room with a glossy floor: the basis within the error that the bake itself tells (at its 97.5 % end),
/// and a final gather, which follows glossy reflections by rays, within the error that one reflection leaves of it.
TEST(Gloss, AgreesWithPathTracing) {
    for (const LobeShape shape : {LobeShape{Model::phong, 30.0}, LobeShape{Model::ggx, 0.4}}) {
        BakeOptions options = small(2000, 256, 10);
        options.error_points = 512;
        const BakeResult result = bake(test::registry(), glossy_room(shape), "room", options, Execution{2});
        const TracedRoom traced(test::registry(), *result.scene, 48, 16384, 11, Execution{2});
        const TracedRoom::Judgement basis =
            traced.judge(result.field().at(traced.places(), 0, 1, "judged", Execution{2}).H);
        const TracedRoom::Judgement gather =
            traced.judge(result.field().at(traced.places(), 4096, 1, "judged", Execution{2}).H);
        // Squares of what a bake tells of its radiosity, and of that times the largest reflectance: places are few, and
        // most errors are around the lamp.
        const double told = result.error->total.high / result.error->reflected;
        EXPECT_LT(basis.squared, told * told + 4.5 * basis.deviation) << std::sqrt(std::abs(basis.squared));
        const double gathered = 0.7 * told;
        EXPECT_LT(gather.squared, gathered * gathered + 4.5 * gather.deviation) << std::sqrt(std::abs(gather.squared));
    }
}

/// The error that a bake tells of itself includes that of the harmonics: the more there are, the smaller it is.
TEST(Gloss, MoreHarmonicsMakeSmallerErrors) {
    double before = 1.0;
    for (const int order : {0, 4, 12}) {
        BakeOptions options = small(800, 512, order);
        options.error_points = 400;
        const BakeResult result = test::baked(glossy_room({Model::phong, 40.0}), options);
        const double error = result.error->total.rms / result.error->reflected;
        EXPECT_LT(error, 0.85 * before) << order;
        before = error;
    }
}

/// A lobe of exponent n spreads by about 1 / sqrt(n); as n grows the floor becomes a mirror. Light of a wall whose edge
/// a point of the opposite wall sees in the floor changes by the square of that.
TEST(Gloss, ANarrowLobeIsNearlyAMirror) {
    Rgb light[2];
    for (const bool mirror : {false, true}) {
        Scene scene = glossy_room({Model::phong, 10000.0});
        for (Material& material : scene.materials) {
            material.reflectance = Rgb::Zero();
            material.emission = Rgb::Zero();
        }
        scene.materials[2].emission = Rgb::Ones(); // too large for an area light
        if (mirror) {
            scene.materials[0].mirror = scene.materials[0].gloss->reflectance;
            scene.materials[0].gloss.reset();
        }
        BakeOptions options = small(200, 64);
        const BakeResult result = test::baked(std::move(scene), options);
        const SurfacePoint x = result.scene->mesh.at(2, 0.2, 0.4); // on the ceiling
        const Irradiance H = result.field().gather(std::span(&x, 1), 16384, 1, "one", Execution{2});
        light[mirror ? 1 : 0] = (H.direct + H.indirect).row(0).transpose().replicate(3, 1).topRows(3).array();
    }
    EXPECT_GT(light[1][0], 0.0);
    EXPECT_NEAR(light[0][0], light[1][0], 0.01 * light[1][0]);
}

/// The sums of the samples with directions are the irradiance: exactly, for suns and point lights; in the mean, for
/// area lights, whose samples come from where the lamps are.
TEST(Gloss, SamplesWithDirectionsAddUpToTheIrradiance) {
    Scene scene = glossy_room({Model::phong, 30.0});
    scene.point_lights.push_back({});
    scene.point_lights.back().position = Vec3(3.0, 1.0, 2.0);
    scene.point_lights.back().intensity = Rgb(1, 2, 3);
    const auto engine = test::plugin<Visibility>("cgal");
    engine->build(scene.mesh);
    const DirectLight light(scene, Tracer(scene.mesh, *engine));
    const std::vector<SurfacePoint> x(4096, scene.mesh.at(0, 0.3, 0.2));
    DirectLight::Worker worker;
    RandomStream stream(1, "light");
    std::vector<DirectLight::Arrival> arrivals;
    light.sample_directions(x, stream, arrivals, worker);
    Rgb lamps = Rgb::Zero(), lamp_squares = Rgb::Zero(), point = Rgb::Zero();
    for (const DirectLight::Arrival& arrival : arrivals) {
        EXPECT_NEAR(arrival.towards.norm(), 1.0, 1e-12);
        const Vec3 way = scene.point_lights[0].position - x[0].position;
        if (arrival.from_outside) {
            point += arrival.H / static_cast<double>(x.size());
            EXPECT_LT((arrival.towards - way.normalized()).norm(), 1e-9);
        } else {
            const Vec3 at = x[0].position + arrival.towards * ((2.49 - x[0].position.z()) / arrival.towards.z());
            EXPECT_TRUE(at.x() > 0.799 && at.x() < 1.401 && at.y() > 0.999 && at.y() < 1.601);
            lamps += arrival.H / static_cast<double>(x.size());
            lamp_squares += arrival.H.square() / static_cast<double>(x.size());
        }
    }
    const Rgb exact = light.irradiance(x[0], 64, stream, worker);
    const double spread = std::sqrt((lamp_squares[0] - lamps[0] * lamps[0]) / static_cast<double>(x.size()));
    EXPECT_NEAR(point[0] + lamps[0], exact[0], 4.5 * spread + 1e-9);
    EXPECT_GT(point[0], 0.0);
}

/// A system that is lit otherwise has the bits of a fresh bake with that light, for any number of threads, and light
/// groups add up.
TEST(Gloss, TheSystemServesAnyLight) {
    const BakeResult one = test::baked(glossy_room({Model::ggx, 0.5}), small(300, 64, 4));
    Scene other = glossy_room({Model::ggx, 0.5});
    other.materials[2].emission = Rgb(1, 0, 0);
    other.materials[4].emission = Rgb(3, 30, 3);
    BakeOptions options = small(300, 64, 4);
    const BakeResult fresh = bake(test::registry(), other, "other", options, Execution{2});
    settle_gloss(other);
    const Solution again = one.system->solve(std::make_shared<const Scene>(other), {}, Execution{});
    EXPECT_EQ(again.h, fresh.solution.h);
    options.light_groups = true;
    const BakeResult groups = test::baked(other, options);
    Values sum = Values::Zero(groups.output.H.rows(), 3);
    for (const GroupValues& group : groups.output.groups) {
        sum += group.H;
    }
    EXPECT_LT((sum - fresh.output.H).cwiseAbs().maxCoeff(), 1e-5 * fresh.output.H.maxCoeff());
}

/// The light of a place and of a wall, of which glossy reflection is a good part: the corrected means are those of a
/// final gather, within 2.3 times their 95 % intervals (4.5 standard errors).
TEST(Gloss, GoalsKnowOfIt) {
    const LobeShape shape{Model::phong, 10.0};
    BakeOptions options = small(800, 256, 4);
    GoalRequest place;
    place.name = "ceiling";
    place.places.push_back({Vec3(2.5, 1.5, 2.5), Vec3(0, 0, -1)});
    GoalRequest wall;
    wall.name = "wall";
    wall.materials = {"green"};
    options.goals = {place, wall};
    const BakeResult result = test::baked(glossy_room(shape), options);
    ASSERT_EQ(result.goal_estimates.size(), 2U);
    const Mesh& mesh = result.scene->mesh;
    std::vector<SurfacePoint> on_wall;
    RandomStream stream(4, "wall");
    for (int k = 0; k < 1024; ++k) {
        const double u = stream.uniform(), v = stream.uniform();
        on_wall.push_back(uniform_point(mesh, k % 2 == 0 ? 10 : 11, u, v));
    }
    ASSERT_EQ(mesh.material[on_wall.front().face], 3U);
    const std::vector<SurfacePoint> one = result.goals[0].places;
    ASSERT_EQ(one.size(), 1U);
    const std::vector<std::vector<SurfacePoint>> places{std::vector<SurfacePoint>(64, one.front()), on_wall};
    for (std::size_t k = 0; k < 2; ++k) {
        const GoalEstimate& goal = result.goal_estimates[k];
        const Irradiance H = result.field().gather(places[k], 1024, 9, "reference", Execution{2});
        const Values all = H.direct + H.indirect;
        const Eigen::RowVectorXd mean = all.colwise().mean();
        const double deviation =
            std::sqrt((all.col(0).array() - mean[0]).square().mean() / static_cast<double>(places[k].size()));
        EXPECT_NEAR(goal.mean[0], mean[0], 2.3 * 0.5 * (goal.high[0] - goal.low[0]) + 4.5 * deviation + 0.005 * mean[0])
            << goal.name;
    }
}

TEST(Gloss, CostsNothingWhereThereIsNone) {
    Scene scene = glossy_room({Model::ggx, 0.5});
    scene.materials[0].gloss.reset();
    const BakeResult result = test::baked(std::move(scene), small(200, 64));
    EXPECT_FALSE(result.glossy);
    EXPECT_EQ(result.system->transport().glossy, nullptr);
    EXPECT_EQ(glossy_part(*result.system->transport().W), nullptr);
}

/// A point light in a Phong floor is brightest where the mirror image is seen, from any eye: the highlight moves.
TEST(Gloss, TheHighlightIsWhereTheMirrorImageIs) {
    for (const Vec3& eye : {Vec3(3.5, 0.5, 1.5), Vec3(0.5, 2.5, 1.2)}) {
        Scene scene = glossy_room({Model::phong, 2000.0});
        scene.materials[4].emission = Rgb::Zero();
        for (std::size_t m = 0; m < scene.materials.size(); ++m) {
            scene.materials[m].reflectance = Rgb::Zero();
        }
        const Vec3 lamp(1.5, 1.2, 2.0);
        scene.point_lights.push_back({});
        scene.point_lights.back().position = lamp;
        scene.point_lights.back().intensity = Rgb::Ones();
        const BakeResult result = test::baked(std::move(scene), small(200, 64));
        ViewOptions view;
        const Vec3 image(lamp.x(), lamp.y(), -lamp.z());
        const Vec3 expected = eye + (image - eye) * (eye.z() / (eye.z() - image.z()));
        view.camera.eye = eye;
        view.camera.towards = (expected + Vec3(0.1, 0.05, 0.0) - eye).normalized();
        view.camera.up = Vec3::UnitZ();
        view.camera.view_angle = 0.5;
        view.width = view.height = 121;
        view.samples = 1;
        view.glossy_rays = 1;
        const View seen = look(result, view, {parse_show("radiosity")}, Execution{2});
        const auto brightest = std::max_element(seen.values[0].begin(), seen.values[0].end(),
                                                [](const auto& a, const auto& b) { return a[0] < b[0]; }) -
                               seen.values[0].begin();
        const CameraRays camera(view.camera, view.width, view.height);
        const auto place = camera.place_of(expected);
        ASSERT_TRUE(place);
        EXPECT_NEAR(static_cast<double>(brightest % 121) + 0.5, (*place)[0], 1.5);
        EXPECT_NEAR(static_cast<double>(brightest / 121) + 0.5, (*place)[1], 1.5);
    }
}

TEST(Gloss, WhatCannotBeCombinedIsRefused) {
    const auto refused = [](Scene scene, const BakeOptions& options) -> std::string {
        try {
            test::baked(std::move(scene), options);
        } catch (const std::exception& error) {
            return error.what();
        }
        return "";
    };
    const LobeShape shape{Model::phong, 20.0};
    BakeOptions options = small(100, 16);
    options.transport = "pairwise";
    EXPECT_THAT(refused(glossy_room(shape), options), testing::HasSubstr("--no-gloss"));
    options = small(100, 16);
    options.solver = "gauss-seidel";
    EXPECT_THAT(refused(glossy_room(shape), options), testing::HasSubstr("relaxing one unknown"));
    options = small(100, 16);
    options.every_surface = true;
    const BakeResult glossy = test::baked(glossy_room(shape), options);
    EXPECT_THROW(saved_transport_of(glossy), UsageError);
    options.gloss = false;
    EXPECT_NO_THROW(saved_transport_of(test::baked(glossy_room(shape), options)));
    Scene mirrors = glossy_room(shape);
    mirrors.materials[2].mirror = Rgb::Constant(0.2);
    EXPECT_THAT(refused(mirrors, small(100, 16)), testing::HasSubstr("together with mirrors"));
    options = small(100, 16);
    options.gloss = false;
    EXPECT_THAT(refused(mirrors, options), testing::IsEmpty());
    Scene warm = glossy_room(shape);
    for (Material& material : warm.materials) {
        material.thermal = Thermal{};
        material.emission = Rgb::Zero();
    }
    EXPECT_THAT(refused(warm, small(100, 16)), testing::HasSubstr("temperatures"));
    Scene bright = glossy_room(shape);
    bright.materials[0].reflectance = Rgb::Constant(0.5);
    EXPECT_THAT(refused(bright, small(100, 16)), testing::HasSubstr("more than all of the light"));
    Scene unsound = glossy_room({Model::ggx, 0.001});
    EXPECT_THAT(refused(unsound, small(100, 16)), testing::HasSubstr("roughness outside"));
    options = small(100, 16, LobeHarmonics::most_order + 1);
    EXPECT_THAT(refused(glossy_room(shape), options), testing::HasSubstr("--directional-order"));
}

} // namespace
} // namespace difusa::gloss_test
