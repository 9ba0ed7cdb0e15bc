// A relit scene has the same bits as one that is baked in this light from nothing, and costs no gather ray.
#include <difusa/bake/relight.h>
#include <difusa/bake/sun_path.h>
#include <difusa/core/random.h>
#include <difusa/scene/sky_dome.h>

#include <support/lightings.h>
#include <support/refusal.h>
#include <support/saved_bakes.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace difusa::relight_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

BakeResult relit(const SavedTransport& saved, const Scene& scene, const RelightOptions& how, unsigned threads = 2) {
    return relight(test::registry(), saved, scene, "scene", how, Execution{threads, nullptr, nullptr});
}

RelightOptions without_estimate(const SavedTransport& saved) {
    RelightOptions how;
    how.bake = relight_defaults(saved);
    how.bake.error_points = 0;
    return how;
}

/// Bit for bit.
void expect_same_result(const BakeResult& a, const BakeResult& b) {
    EXPECT_EQ(a.solution.h, b.solution.h);
    EXPECT_EQ(a.solution.direct, b.solution.direct);
    EXPECT_EQ(a.solution.irradiance, b.solution.irradiance);
    EXPECT_EQ(a.solution.spectral_radius, b.solution.spectral_radius);
    EXPECT_EQ(a.solution.first_bounce, b.solution.first_bounce);
    EXPECT_TRUE((a.solution.energy.absorbed == b.solution.energy.absorbed).all());
    EXPECT_EQ(a.field().parts().smooth, b.field().parts().smooth);
    EXPECT_EQ(a.output.B, b.output.B);
    EXPECT_EQ(a.output.H, b.output.H);
    EXPECT_EQ(a.output.H_direct, b.output.H_direct);
    EXPECT_EQ(a.plugins, b.plugins);
    EXPECT_EQ(a.options.output_spacing, b.options.output_spacing);
    ASSERT_EQ(a.output.groups.size(), b.output.groups.size());
    for (std::size_t g = 0; g < a.output.groups.size(); ++g) {
        EXPECT_EQ(a.output.groups[g].name, b.output.groups[g].name);
        EXPECT_EQ(a.output.groups[g].B, b.output.groups[g].B);
    }
    ASSERT_EQ(a.error.has_value(), b.error.has_value());
    if (a.error) {
        EXPECT_EQ(a.error->total.rms, b.error->total.rms);
        EXPECT_EQ(a.error->bound, b.error->bound);
    }
}

TEST(Relight, HasTheBitsOfAFreshBake) {
    for (const char* transport : {"gather", "pairwise"}) {
        for (const char* basis : {"", "normalized-radial"}) {
            BakeOptions options = test::relightable(transport, basis);
            const auto scenes = test::lightings();
            const SavedTransport saved = test::through_file(lit::baked(scenes.front().second, options));
            for (const auto& [name, scene] : scenes) {
                SCOPED_TRACE(name + ", " + transport + ", " + basis);
                RelightOptions how = without_estimate(saved);
                options.light_groups = how.bake.light_groups = transport == std::string("gather");
                const BakeResult again = relit(saved, scene, how);
                expect_same_result(again, lit::baked(scene, options));
                EXPECT_EQ(again.journal.count_of("rays"), 0U);
            }
        }
    }
}

/// Sites, rays and shadow rays are what an accuracy took; graded sites are closer together than their spacing in
/// places.
TEST(Relight, KeepsWhatAnAccuracyTook) {
    const Scene scene = test::lightings().front().second;
    BakeOptions options = test::relightable("gather", "");
    options.spacing = 0.0;
    options.sites = 0;
    options.error_points.reset();
    options.target = ErrorTarget{};
    options.target->relative = 0.02;
    options.shadow_rays = 96;
    const BakeResult baked = lit::baked(scene, options);
    ASSERT_TRUE(baked.sites->graded);
    const SavedTransport saved = test::through_file(baked);
    EXPECT_TRUE(saved.options.adaptive);
    const BakeOptions defaults = relight_defaults(saved);
    EXPECT_EQ(defaults.shadow_rays, baked.options.shadow_rays);
    EXPECT_EQ(relit(saved, scene, without_estimate(saved)).output.B, baked.output.B);
}

/// A floor in cells, most of which have no site of the floor until some are added, which are closer together.
TEST(Relight, AddedSitesDoNotMakeTheOutputFiner) {
    Mesh mesh = rectangle(Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0));
    for (int i = 1; i < 6; ++i) {
        const double at = i / 6.0, half = 0.01;
        add(mesh, box(Vec3(at - half, 0, 0), Vec3(at + half, 1, 0.2), 1, Front::outside), 0);
        add(mesh, box(Vec3(0, at - half, 0), Vec3(1, at + half, 0.2), 1, Front::outside), 0);
    }
    mesh.material.assign(mesh.triangles.size(), 0);
    const Scene scene = test::uniform_scene(std::move(mesh), 0.5, 0.0);
    BakeOptions options = test::relightable("gather", "");
    options.sky = Rgb::Ones();
    options.spacing = 0.3;
    options.sites = 0;
    const BakeResult baked = lit::baked(scene, options);
    ASSERT_LT(baked.sites->spacing, 0.9 * options.spacing);
    const SavedTransport saved = test::through_file(baked);
    expect_same_result(relit(saved, scene, without_estimate(saved)), baked);
}

/// Whether bounces die out was found out by the bake, and holds as long as reflectances and elements are the same.
TEST(Relight, TakesTheSpectralRadiusOfTheBakeWhereItIsTheSame) {
    const BakeOptions options = test::relightable("gather", "");
    const Scene bare = test::bare_room();
    const BakeResult baked = lit::baked(bare, options);
    SavedTransport saved = test::through_file(baked);
    ASSERT_TRUE(saved.contraction);
    EXPECT_EQ(saved.contraction->radius, baked.solution.spectral_radius);
    EXPECT_EQ(saved.contraction->reflectance, reflectance_fingerprint(baked.solution.light.reflectance));
    saved.contraction->radius = 0.125; // to be recognised
    const RelightOptions how = without_estimate(saved);
    Scene other = bare;
    for (Material& material : other.materials) {
        material.emission *= 3.0;
    }
    EXPECT_EQ(relit(saved, other, how).solution.spectral_radius, 0.125);
    for (Material& material : other.materials) {
        material.reflectance *= 0.5;
    }
    EXPECT_EQ(relit(saved, other, how).solution.spectral_radius, lit::baked(other, options).solution.spectral_radius);
    saved.elements = "others";
    EXPECT_EQ(relit(saved, bare, how).solution.spectral_radius, baked.solution.spectral_radius);
}

TEST(Relight, AllOutputsAreThoseOfAFreshBake) {
    BakeOptions options = test::relightable("gather", "");
    options.projection = "galerkin";
    const auto scenes = test::lightings();
    const SavedTransport saved = test::through_file(lit::baked(scenes.front().second, options));
    RelightOptions how{std::nullopt, {}, relight_defaults(saved)};
    for (BakeOptions* each : {&options, &how.bake}) {
        each->error_points = 64;
        each->final_gather = 16;
        each->at = {{Vec3(0.5, 0.5, 0.1), {}}, {Vec3(0.6, 0.6, 0.7), Vec3::UnitZ()}};
        each->face_centres = true;
        each->output_spacing = 0.5;
        each->goals = {{"wall", {"wall"}, {}, {}}};
        each->goal_samples = 64;
    }
    const BakeResult a = relit(saved, scenes[3].second, how), b = lit::baked(scenes[3].second, options);
    expect_same_result(a, b);
    EXPECT_EQ(a.centres->B, b.centres->B);
    EXPECT_EQ(a.listed_values.H, b.listed_values.H);
    EXPECT_EQ(a.readings.H, b.readings.H);
    EXPECT_EQ(a.errors->error, b.errors->error);
    EXPECT_TRUE((a.goal_estimates.at(0).mean == b.goal_estimates.at(0).mean).all());
    EXPECT_GT(a.journal.count_of("output rays"), 0U);
}

/// The lights that the bake's options added are there again, and can be changed.
TEST(Relight, ChangesAreThoseOfTheScene) {
    BakeOptions options = test::relightable("gather", "");
    options.suns = {{Vec3(0.3, -1, 2).normalized(), Rgb(3, 2, 1)}};
    const Scene bare = test::bare_room();
    const SavedTransport saved = test::through_file(lit::baked(bare, options));
    RelightOptions how = without_estimate(saved);
    const auto expect_same_as = [&](const std::string& what, const auto& change) {
        SCOPED_TRACE(what);
        Scene scene = bare;
        BakeOptions fresh = options;
        change(scene, fresh);
        expect_same_result(relit(saved, bare, how), lit::baked(scene, fresh));
        how = without_estimate(saved);
    };
    expect_same_as("nothing", [](Scene&, BakeOptions&) {});
    how.change.emission = {{"lamp", Rgb(9, 8, 7)}, {"panel", Rgb(1, 0, 0)}};
    expect_same_as("emission", [](Scene& scene, BakeOptions&) {
        scene.materials[2].emission = Rgb(9, 8, 7);
        scene.materials[1].emission = Rgb(1, 0, 0);
    });
    how.change.reflectance = {{"room", Rgb(0.9, 0.5, 0.25)}};
    expect_same_as("reflectance",
                   [](Scene& scene, BakeOptions&) { scene.materials[0].reflectance = Rgb(0.9, 0.5, 0.25); });
    how.change.scale = {{"sun", 0.25}};
    expect_same_as("a dimmer sun", [](Scene&, BakeOptions& fresh) { fresh.suns[0].irradiance *= 0.25; });
    how.change.scale = {{"sun", 0.0}};
    how.bake.suns = {{Vec3(0, 0.6, 0.8), Rgb::Constant(2.0)}};
    expect_same_as("another sun", [](Scene&, BakeOptions& fresh) {
        fresh.suns = {{Vec3(0.3, -1, 2).normalized(), Rgb::Zero()}, {Vec3(0, 0.6, 0.8), Rgb::Constant(2.0)}};
    });
    how.bake.sky = Rgb(1, 2, 3);
    how.bake.point_lights = {{Vec3(1, 1, 1), Rgb::Ones()}};
    expect_same_as("a sky and a point light", [](Scene&, BakeOptions& fresh) {
        fresh.sky = Rgb(1, 2, 3);
        fresh.point_lights = {{Vec3(1, 1, 1), Rgb::Ones()}};
    });
}

TEST(Relight, ASkyIsScaled) {
    Scene scene = test::bare_room();
    const SavedTransport saved = test::through_file(lit::baked(scene, test::relightable("gather", "")));
    scene.dome = std::make_shared<GradientSky>(Rgb(1, 2, 3), Rgb(3, 2, 1), Rgb(1, 1, 1), Vec3::UnitZ());
    RelightOptions how = without_estimate(saved);
    const BakeResult once = relit(saved, scene, how);
    how.change.scale = {{"sky", 2.0}};
    const BakeResult twice = relit(saved, scene, how);
    EXPECT_EQ(twice.output.H, Values(2.0 * once.output.H)) << "a power of two: no rounding";
    how.change.scale = {{"sky", 0.0}};
    how.change.emission = {{"lamp", Rgb::Ones()}};
    EXPECT_FALSE(relit(saved, scene, how).scene->has_sky());
}

/// Light is additive: random lights together give the sum of each alone, within the tolerance of the solver. Where the
/// shadow rays of several sharp lights go depends on all of them: a single one, the sun, shines beside soft ones.
TEST(Relight, RandomLightsAddUp) {
    Scene bare = test::bare_room();
    bare.materials[3].emission_texture = test::checks(); // no area light
    BakeOptions options = test::relightable("gather", "normalized-radial");
    options.projection = "natural";
    const SavedTransport saved = test::through_file(lit::baked(bare, options));
    RandomStream random(3, "lights");
    const auto light = [&] { return Rgb(random.uniform(), random.uniform(), random.uniform()); };
    for (int trial = 0; trial < 10; ++trial) {
        RelightOptions how = without_estimate(saved);
        how.bake.sky = light();
        how.change.emission = {{"wall", light()}};
        how.change.reflectance = {{"room", light()}, {"wall", light()}};
        how.bake.suns = {{Vec3(random.uniform() - 0.5, random.uniform() - 0.5, 1.0).normalized(), light()}};
        how.bake.first_bounce = "operator"; // samples on what is bright differ where something else is bright, too
        const BakeResult together = relit(saved, bare, how);
        RelightOptions sky = how, sun = how, wall = how;
        sky.bake.suns.clear();
        sky.change.emission.clear();
        sun.bake.sky = Rgb::Zero();
        sun.change.emission.clear();
        wall.bake.suns.clear();
        wall.bake.sky = Rgb::Zero();
        const Values sum = relit(saved, bare, sky).solution.irradiance + relit(saved, bare, sun).solution.irradiance +
                           relit(saved, bare, wall).solution.irradiance;
        // Four solutions, each within the tolerance times what arrives directly, amplified by at most 1 / (1 - radius).
        const double radius = together.solution.spectral_radius;
        ASSERT_LT(radius, 1.0);
        const double bound =
            8.0 * saved.options.solve.tolerance * together.solution.irradiance.maxCoeff() / (1.0 - radius);
        EXPECT_LE((sum - together.solution.irradiance).cwiseAbs().maxCoeff(), bound);
    }
}

/// A small patch of sun: the rays of a coarse bake hardly find it, the samples on it do. Both are about the same light.
TEST(Relight, TheFirstBounceIsLiveOrOfTheOperator) {
    const Mesh box = test::box(1.0, 1, true);
    Scene scene = test::uniform_scene(box, 0.5, 0.0);
    PointLight spot{Vec3(0.5, 0.5, 0.9), Rgb::Constant(10.0)};
    spot.cos_inner = 0.99;
    spot.cos_outer = 0.98;
    scene.point_lights = {spot};
    BakeOptions options = lit::quick(0.2, 128);
    options.every_surface = true;
    const SavedTransport saved = test::through_file(lit::baked(scene, options));
    RelightOptions how = without_estimate(saved);
    const BakeResult live = relit(saved, scene, how);
    EXPECT_EQ(live.solution.first_bounce, FirstBounce::live);
    how.bake.first_bounce = "operator";
    const BakeResult product = relit(saved, scene, how);
    EXPECT_EQ(product.solution.first_bounce, FirstBounce::operator_only);
    const double a = live.solution.h.mean(), b = product.solution.h.mean();
    EXPECT_NE(a, b);
    EXPECT_NEAR(a, b, 0.2 * a);
    how.bake.first_bounce = "alive";
    EXPECT_THROW(relit(saved, scene, how), UsageError);
}

TEST(Relight, TheSystemLivesOn) {
    const auto scenes = test::lightings();
    const BakeOptions options = test::relightable("gather", "");
    const SavedTransport saved = test::through_file(lit::baked(scenes.front().second, options));
    const BakeResult first = relit(saved, scenes.front().second, without_estimate(saved));
    for (const auto& [name, scene] : scenes) {
        const auto shared = std::make_shared<Scene>(scene);
        EXPECT_EQ(first.system->solve(shared, {}, Execution{}).irradiance,
                  lit::baked(scene, options).solution.irradiance)
            << name;
    }
}

/// Eighteen times, in blocks: each has the bits of a relit scene with this one sun.
TEST(Relight, ADayIsOneSunAfterAnother) {
    Scene scene = test::bare_room();
    scene.sky = Rgb(1, 2, 3);
    scene.materials[2].emission = Rgb(9, 8, 7);
    BakeOptions options = test::relightable("gather", "");
    options.suns = {{Vec3::UnitZ(), Rgb::Ones()}};
    const SavedTransport saved = test::through_file(lit::baked(scene, options));
    SunPath path;
    path.latitude = 40.0;
    path.date = {2025, 4, 1};
    path.step = 0.5;
    path.from = 8.0;
    path.to = 16.5;
    for (const bool groups : {false, true}) {
        RelightOptions how = without_estimate(saved);
        how.bake.light_groups = groups;
        how.bake.at = {{Vec3(0.5, 0.5, 0.1), {}}};
        const std::vector<SunStep> steps = sun_steps(path, Vec3::UnitZ());
        ASSERT_EQ(steps.size(), 18U);
        std::size_t seen = 0;
        const auto compare = [&](const SunStep& step, const BakeResult& result) {
            ASSERT_EQ(step.hours, steps[seen].hours);
            // The sun of the path comes after those of the bake's options.
            how.bake.suns = {steps[seen++].sun};
            const BakeResult alone = relit(saved, scene, how);
            expect_same_result(result, alone);
            EXPECT_EQ(result.listed_values.H, alone.listed_values.H);
            how.bake.suns.clear();
        };
        relight_sun_path(test::registry(), saved, scene, "scene", how, path, compare, Execution{2, nullptr, nullptr});
        EXPECT_EQ(seen, steps.size());
    }
}

TEST(Relight, RefusesAnotherSurface) {
    const Scene scene = test::bare_room();
    const SavedTransport saved = test::through_file(lit::baked(scene, test::relightable("gather", "")));
    Scene moved = scene;
    moved.mesh.points[0].z() -= 1e-12;
    moved.mesh.derive();
    EXPECT_THAT([&] { relit(saved, moved, without_estimate(saved)); },
                ThrowsMessage<InputError>(AllOf(HasSubstr("is not the one"), HasSubstr("--scene"))));
    Scene turned = scene;
    turned.mesh.turn_over(0);
    turned.mesh.derive();
    EXPECT_THROW(relit(saved, turned, without_estimate(saved)), InputError);
    SavedTransport other = saved;
    other.turned_over = {0};
    EXPECT_NO_THROW(relit(
        [&] {
            other.geometry = geometry_fingerprint(scene.mesh);
            return other;
        }(),
        turned, without_estimate(saved)));
    other.turned_over = {none};
    EXPECT_THROW(relit(other, scene, without_estimate(saved)), InputError);
}

TEST(Relight, RefusesSitesThatAreNotOnTheSurfaceAndAnotherDivision) {
    const Scene scene = test::bare_room();
    const SavedTransport saved = test::through_file(lit::baked(scene, test::relightable("gather", "")));
    const auto refused = [&](const std::string& why, const auto& damage) {
        SavedTransport bad = saved;
        auto sites = std::make_shared<SiteSet>(*saved.sites);
        damage(bad, *sites);
        bad.sites = sites;
        EXPECT_THAT([&] { relit(bad, scene, without_estimate(bad)); }, ThrowsMessage<InputError>(HasSubstr(why)));
    };
    const std::string off = "is not on the surface", other = "divides the surface otherwise";
    refused(off, [](SavedTransport&, SiteSet& sites) { sites.points[0].face = 100000; });
    refused(off, [](SavedTransport&, SiteSet& sites) { sites.points[0].position.x() += 0.1; });
    refused(off, [](SavedTransport&, SiteSet& sites) { sites.radius[0] = 1e9; });
    refused(off, [](SavedTransport&, SiteSet& sites) { ++sites.region[0]; });
    refused(other, [](SavedTransport& bad, SiteSet&) { ++bad.discretisation; });
    refused(other, [](SavedTransport& bad, SiteSet&) { ++bad.gathered.surfels; });
}

TEST(Relight, RefusesChangesThatCannotBeMade) {
    const Scene scene = test::bare_room();
    BakeOptions options = test::relightable("gather", "");
    options.sky = Rgb::Ones();
    const SavedTransport saved = test::through_file(lit::baked(scene, options));
    const auto refused = [&](const std::string& what, const auto& change) {
        RelightOptions how = without_estimate(saved);
        change(how);
        EXPECT_THAT([&] { relit(saved, scene, how); }, ThrowsMessage<UsageError>(HasSubstr(what)));
    };
    refused("no material `lmap`, did you mean lamp?", [](RelightOptions& how) {
        how.change.emission = {{"lmap", Rgb::Ones()}};
    });
    refused("There are: sky", [](RelightOptions& how) { how.change.scale = {{"moon", 1.0}}; });
    refused("at least 0", [](RelightOptions& how) { how.change.scale = {{"sky", -1.0}}; });
    refused("from 0 to 1", [](RelightOptions& how) { how.change.reflectance = {{"lamp", Rgb(1.5, 0, 0)}}; });
    refused("must be 0, or from 1e-100 to 1e100", [](RelightOptions& how) {
        how.change.emission = {{"lamp", Rgb(-1, 0, 0)}};
    });
    RelightOptions dark = without_estimate(saved);
    dark.change.scale = {{"sky", 0.0}};
    EXPECT_EQ(relit(saved, scene, dark).output.B.cwiseAbs().maxCoeff(), 0.0); // on purpose
    dark.bake.sky = Rgb::Zero();
    EXPECT_THAT([&] { relit(saved, scene, dark); },
                ThrowsMessage<InputError>(HasSubstr("all lights of the scene are dark")));
}

} // namespace
} // namespace difusa::relight_test
