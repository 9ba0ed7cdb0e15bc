#include <difusa/import/shapes.h>
#include <difusa/lighting/direct_light.h>
#include <difusa/lighting/surfel_light.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/rays/brute_force.h>
#include <difusa/rays/lambert.h>
#include <difusa/transport/gathered.h>

#include <support/sited.h>

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

namespace difusa::direct_light_test {
namespace {

/// A scene of these meshes with one material of reflectance 1/2 and a visibility engine on it.
struct Lit {
    Scene scene;
    BruteForceVisibility visibility;
    explicit Lit(Mesh mesh, std::vector<Sun> suns = {}) {
        scene.mesh = std::move(mesh);
        scene.materials.resize(1);
        scene.suns = std::move(suns);
        visibility.build(scene.mesh);
    }
    Tracer tracer() const { return {scene.mesh, visibility}; }
};

/// What comes from suns and point lights, of which there are no other lights.
Rgb light_at(const DirectLight& light, const SurfacePoint& x) {
    DirectLight::Worker worker;
    RandomStream stream(1, "unused");
    return light.irradiance(x, 64, stream, worker);
}

Mesh floor_with_screen() {
    Mesh mesh = rectangle(Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 4, 0));
    add(mesh, rectangle(Vec3(1, 1, 1), Vec3(1, 0, 0), Vec3(0, 1, 0)), 0); // facing up: its back blocks
    return mesh;
}

TEST(DirectLight, ANarrowBeamOfALargeOpeningIsNotMissed) {
    // From below, only a thirtieth of the opening is within the beam, which ends at 2.5 degrees; nothing blocks it.
    Lit lit(rectangle(Vec3(-2, -2, 0), Vec3(4, 0, 0), Vec3(0, 4, 0)));
    PointLight beam;
    beam.position = Vec3(0, 0, 3);
    beam.intensity = Rgb(1, 2, 3);
    beam.half_length = beam.half_width = 0.6;
    beam.distribution = std::make_shared<IntensityDistribution>(
        IntensityDistribution::Table{PhotometryType::C, {0}, {0, 2, 2.5, 90}, {1, 1, 0, 0}});
    lit.scene.point_lights.push_back(beam);
    const DirectLight light(lit.scene, lit.tracer());
    for (const SurfacePoint& x : even_points(lit.scene.mesh, 400, RandomStream(1, "points"))) {
        if (x.position.cwiseAbs().maxCoeff() < 0.4) {
            const double kernel = beam.mean_kernel(x.position, x.normal);
            EXPECT_GT(kernel, 0.0);
            EXPECT_TRUE(light_at(light, x).isApprox(kernel * beam.intensity, 1e-12)) << x.position.transpose();
        }
    }
}

TEST(DirectLight, ASunGivesTheCosineOrNothing) {
    const Vec3 s = Vec3(0.3, 0.2, 1.0).normalized();
    const Lit lit(floor_with_screen(), {{s, Rgb(1, 2, 3)}});
    const DirectLight light(lit.scene, lit.tracer());
    DirectLight::Worker worker;
    RandomStream stream(1, "unused");
    int shaded = 0;
    const std::vector<SurfacePoint> points = even_points(lit.scene.mesh, 2000, RandomStream(1, "points"));
    std::vector<Rgb> H(points.size());
    light.sample(points, stream, H, worker);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const SurfacePoint& x = points[i];
        const Vec3 above = x.position + s / s.z(); // where the ray is at the height of the screen
        const bool blocked = x.face < 2 && above.x() > 1 && above.x() < 2 && above.y() > 1 && above.y() < 2;
        const Rgb expected = blocked ? Rgb(0, 0, 0) : Rgb(s.z() * Rgb(1, 2, 3));
        EXPECT_TRUE((light.irradiance(x, 64, stream, worker) == expected).all()) << x.position.transpose();
        EXPECT_TRUE((H[i] == expected).all());
        shaded += blocked ? 1 : 0;
    }
    EXPECT_GT(shaded, 50);
}

TEST(DirectLight, NothingIsCastWhereNoSuchLightIs) {
    const Lit lit(floor_with_screen(), {{Vec3::UnitZ(), Rgb::Zero()}});
    const DirectLight light(lit.scene, lit.tracer());
    EXPECT_FALSE(light.any());
    EXPECT_EQ(light.rays_per_point(64), 0U);
    DirectLight::Effort effort;
    const std::vector<SurfacePoint> points = even_points(lit.scene.mesh, 10, RandomStream(1, "points"));
    EXPECT_EQ(light.irradiance(points, 3, 64, 1, "test", Execution{}, effort), Values::Zero(10, 3));
    EXPECT_EQ(effort.segments, 0U);
}

TEST(DirectLight, ASunBelowTheHorizonOrBehindTheSurfaceIsDark) {
    const Lit lit(floor_with_screen(), {{Vec3(1, 0, 0), Rgb::Ones()}, {-Vec3::UnitZ(), Rgb::Ones()}});
    const DirectLight light(lit.scene, lit.tracer());
    EXPECT_TRUE((light_at(light, lit.scene.mesh.at(0, 0.2, 0.2)) == 0.0).all());
}

/// A ball of facets with the normals of the sphere: the sun's irradiance is the cosine all over the lit half, also
/// where the facet itself looks away from the sun already.
TEST(DirectLight, ShadingNormalsFaceSunsThatTheirFacetsDoNot) {
    const Vec3 s = Vec3(1, 2, 3).normalized();
    const Lit lit(sphere(1.0, 3, Front::outside), {{s, Rgb::Ones()}});
    const DirectLight light(lit.scene, lit.tracer());
    int grazing = 0;
    for (SurfacePoint x : even_points(lit.scene.mesh, 5000, RandomStream(1, "points"))) {
        const Vec3& facet = lit.scene.mesh.normals[x.face];
        x.normal = x.position.normalized();
        const double cosine = x.normal.dot(s);
        grazing += cosine > 0.0 && facet.dot(s) < 0.0 ? 1 : 0;
        EXPECT_EQ(light_at(light, x)[0], cosine > 0.0 ? cosine : 0.0);
    }
    EXPECT_GT(grazing, 10);
}

/// Of many lights a sample draws some: right on average, and in a bounded number of rays.
TEST(DirectLight, SamplesOfManyLightsAreUnbiased) {
    Lit lit(floor_with_screen());
    RandomStream random(1, "lights");
    for (int i = 0; i < 3000; ++i) {
        PointLight light;
        light.position = Vec3(4.0 * random.uniform(), 4.0 * random.uniform(), 2.0 + random.uniform());
        light.intensity = std::pow(random.uniform(), 3.0) * Rgb(1, 2, 3);
        lit.scene.point_lights.push_back(light);
        Sun sun;
        sun.towards = Vec3(random.uniform(), random.uniform(), 0.1 + random.uniform()).normalized();
        sun.irradiance = Rgb::Constant(random.uniform());
        lit.scene.suns.push_back(sun);
    }
    const DirectLight light(lit.scene, lit.tracer());
    EXPECT_EQ(light.rays_per_point(1), 6000U);
    EXPECT_EQ(light.rays_per_sample(), 2 * DirectLight::most_sampled);
    const SurfacePoint x = lit.scene.mesh.at(0, 0.3, 0.3);
    const double exact = light_at(light, x)[2];
    constexpr int draws = 400;
    double sum = 0.0, squares = 0.0;
    DirectLight::Worker worker;
    RandomStream stream(1, "draws");
    for (int i = 0; i < draws; ++i) {
        Rgb H = Rgb::Zero();
        light.sample({&x, 1}, stream, {&H, 1}, worker);
        sum += H[2];
        squares += H[2] * H[2];
    }
    EXPECT_LE(worker.cast, draws * light.rays_per_sample());
    const double mean = sum / draws, deviation = std::sqrt((squares / draws - mean * mean) / (draws - 1.0));
    EXPECT_NEAR(mean, exact, 4.0 * deviation); // exceeded by chance once in 16,000 seeds
    EXPECT_LT(deviation * std::sqrt(draws), 0.3 * exact);
}

/// A street of equal lamps, of which the few near ones give nearly all of the light. At the foot of the first, lights
/// in their order give less and less for each share of the draws, at most 4/3 of all light, and the sum of a falling
/// function at 256 even places is off by at most the first of the steps, whatever they begin with.
TEST(DirectLight, SamplesOfManyLightsAreDrawnWhereTheyAreNear) {
    Lit lit(rectangle(Vec3(-1, -1, 0), Vec3(2, 0, 0), Vec3(0, 2, 0)));
    for (int i = 0; i < 3000; ++i) {
        PointLight light;
        light.position = Vec3(2.0 * i, 0.0, 3.0);
        light.intensity = Rgb::Ones();
        lit.scene.point_lights.push_back(light);
    }
    const DirectLight light(lit.scene, lit.tracer());
    SurfacePoint x = lit.scene.mesh.at(0, 0.3, 0.3);
    x.position = Vec3::Zero();
    const double exact = light_at(light, x)[0];
    DirectLight::Worker worker;
    RandomStream stream(1, "draws");
    for (int i = 0; i < 100; ++i) {
        Rgb H = Rgb::Zero();
        light.sample({&x, 1}, stream, {&H, 1}, worker);
        EXPECT_NEAR(H[0], exact, 4.0 / 3.0 / DirectLight::most_sampled * exact * (1.0 + 1e-12));
    }
}

TEST(DirectLight, SameBitsForAnyNumberOfThreads) {
    Lit lit(rectangle(Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 4, 0)), {{Vec3(0.1, 0, 1).normalized(), Rgb(1, 2, 3)}});
    add(lit.scene.mesh, rectangle(Vec3(1, 1, 1), Vec3(1, 0, 0), Vec3(0, 1, 0), 2, 120), 0); // too much for exact views
    lit.scene.materials.resize(2);
    lit.scene.materials[1].emission = Rgb::Constant(5.0);
    add(lit.scene.mesh, rectangle(Vec3(1.4, 1.2, 3), Vec3(0, 0.5, 0), Vec3(0.5, 0, 0)), 1);
    lit.visibility.build(lit.scene.mesh);
    const DirectLight light(lit.scene, lit.tracer());
    EXPECT_EQ(light.area_light_materials(), (std::vector<char>{0, 1}));
    EXPECT_EQ(light.area_light_count(), 2U);
    EXPECT_EQ(light.rays_per_point(64), 1U + 2 * 64U); // a pilot, and one round that counts
    const std::vector<SurfacePoint> points = even_points(lit.scene.mesh, 300, RandomStream(1, "points"));
    DirectLight::Effort effort, effort_of_three;
    const Values one = light.irradiance(points, 3, 16, 1, "test", Execution{1, nullptr}, effort);
    EXPECT_EQ(one, light.irradiance(points, 3, 16, 1, "test", Execution{3, nullptr}, effort_of_three));
    EXPECT_EQ(effort.segments, effort_of_three.segments);
    EXPECT_EQ(effort.clear, effort_of_three.clear);
    EXPECT_NE(one, light.irradiance(points, 3, 16, 2, "test", Execution{1, nullptr}, effort));
}

/// Two suns, a point light and two lamps, each in a set of its own or not: the sets add up to what all together send.
TEST(DirectLight, SetsAddUp) {
    Lit lit(floor_with_screen(),
            {{Vec3(0.1, 0, 1).normalized(), Rgb(1, 2, 3)}, {Vec3(0, 0.4, 1).normalized(), Rgb(4, 0, 1)}});
    lit.scene.materials.resize(3);
    lit.scene.materials[1].emission = Rgb::Constant(5.0);
    lit.scene.materials[2].emission = Rgb(0, 7, 0);
    lit.scene.materials[1].name = "one lamp";
    lit.scene.materials[2].name = "other lamp";
    lit.scene.suns[1].name = "other sun";
    add(lit.scene.mesh, rectangle(Vec3(1.4, 1.2, 3), Vec3(0, 0.5, 0), Vec3(0.5, 0, 0)), 1);
    add(lit.scene.mesh, rectangle(Vec3(2.4, 3.2, 3), Vec3(0, 0.5, 0), Vec3(0.5, 0, 0)), 2);
    PointLight bulb;
    bulb.position = Vec3(3, 1, 2);
    bulb.intensity = Rgb(1, 1, 2);
    lit.scene.point_lights.push_back(bulb);
    lit.visibility.build(lit.scene.mesh);
    const DirectLight together(lit.scene, lit.tracer()), apart(lit.scene, lit.tracer(), light_groups(lit.scene));
    ASSERT_EQ(apart.area_light_count(), 4U);
    const std::vector<SurfacePoint> points = even_points(lit.scene.mesh, 300, RandomStream(1, "points"));
    DirectLight::Effort one_effort, sets_effort;
    const Values one = together.irradiance(points, 3, 64, 1, "test", Execution{}, one_effort);
    const Values sets = apart.irradiance(points, 3, 64, 1, "test", Execution{}, sets_effort);
    ASSERT_EQ(sets.cols(), 15);
    Values sum = Values::Zero(one.rows(), 3);
    for (Eigen::Index set = 0; set < 5; ++set) {
        EXPECT_GT(sets.middleCols(3 * set, 3).maxCoeff(), 0.0);
        sum += sets.middleCols(3 * set, 3);
    }
    EXPECT_LE((sum - one).cwiseAbs().maxCoeff(), 16 * 0x1p-53 * one.maxCoeff()); // sums of five in another order
    EXPECT_EQ(one_effort.segments, sets_effort.segments);

    // Estimates of one shadow ray draw the same numbers and choose the same lamp.
    DirectLight::Worker worker;
    std::vector<Rgb> all(points.size()), by_set(5 * points.size());
    RandomStream first(2, "sample"), second(2, "sample");
    std::vector<Rgb> outside(points.size());
    together.sample(points, first, all, worker);
    apart.sample(points, second, by_set, worker, outside);
    const LightSets& names = apart.sets();
    for (std::size_t i = 0; i < points.size(); ++i) {
        Rgb total = Rgb::Zero();
        for (std::size_t set = 0; set < 5; ++set) {
            total += by_set[5 * i + set];
        }
        EXPECT_TRUE(((total - all[i]).abs() <= 16 * 0x1p-53 * all[i]).all());
        Rgb expected = Rgb::Zero();
        for (const Index set : {names.sun[0], names.sun[1], names.point[0]}) {
            expected += by_set[5 * i + set];
        }
        EXPECT_TRUE(((outside[i] - expected).abs() <= 4 * 0x1p-53 * expected).all()); // three terms
    }
}

/// A wall beside a floor in the sun: one reflection brings rho times the floor's irradiance times its form factor.
TEST(DirectLight, TheFirstBounceIsGatheredFromSurfels) {
    const Vec3 s = Vec3(0, -1, 1).normalized();
    Mesh mesh = rectangle(Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 2, 0));
    add(mesh, rectangle(Vec3(0, 2, 0), Vec3(2, 0, 0), Vec3(0, 0, 2)), 0);
    const Lit lit(std::move(mesh), {{s, Rgb(1, 2, 3)}});
    const Mesh& m = lit.scene.mesh;
    const Surfels surfels(m, 0.35, Execution{});
    const SurfelLight light =
        light_on_surfels(lit.scene, surfels, DirectLight(lit.scene, lit.tracer()), 3, 1, Execution{});
    EXPECT_GT(light.segments, 0U);
    const SiteSet sites = test::poisson_sites(m, 0.5);
    constexpr std::size_t N = 4096;
    const LightTransport transport =
        gathered(lit.tracer(), sites.points, surfels, *test::plugin<Directions>("low-discrepancy"), N, 1, Execution{});
    Values h;
    transport.gather(light.first_bounce(), {}, h, Execution{});
    ASSERT_EQ(h.rows(), std::ssize(sites.points));
    for (std::size_t j = 0; j < sites.size(); ++j) {
        const SurfacePoint& x = sites.points[j];
        double exact = 0.0;
        for (Index t = 0; t < m.triangles.size(); ++t) {
            // The sun lights floor and wall wholly: nothing is in its way.
            exact += 0.5 * s.dot(m.normals[t]) *
                     lambert_form_factor(x.position, x.normal, m.corner(t, 0), m.corner(t, 1), m.corner(t, 2));
        }
        // Not worse than independent rays: a mean of N values in [0, 1/2 cos].
        EXPECT_NEAR(h(static_cast<Eigen::Index>(j), 0), exact, 4.5 * 0.25 / std::sqrt(double(N)));
        // Sums of N terms in another rounding.
        EXPECT_NEAR(h(static_cast<Eigen::Index>(j), 2), 3.0 * h(static_cast<Eigen::Index>(j), 0), N * 0x1p-53);
    }
}

} // namespace
} // namespace difusa::direct_light_test
