#include <difusa/import/shapes.h>
#include <difusa/lighting/direct_light.h>
#include <difusa/lighting/lambert.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/rays/brute_force.h>
#include <difusa/transport/gather.h>

#include <support/sited.h>

#include <gtest/gtest.h>

#include <cmath>

namespace difusa {
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
};

Mesh floor_with_screen() {
    Mesh mesh = rectangle(Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 4, 0));
    add(mesh, rectangle(Vec3(1, 1, 1), Vec3(1, 0, 0), Vec3(0, 1, 0)), 0); // facing up: its back blocks
    return mesh;
}

TEST(DirectLight, ASunGivesTheCosineOrNothing) {
    const Vec3 s = Vec3(0.3, 0.2, 1.0).normalized();
    const Lit lit(floor_with_screen(), {{s, Rgb(1, 2, 3)}});
    const DirectLight light(lit.scene, lit.visibility);
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
    const DirectLight light(lit.scene, lit.visibility);
    EXPECT_FALSE(light.any());
    EXPECT_EQ(light.rays_per_point(64), 0U);
    DirectLight::Effort effort;
    const std::vector<SurfacePoint> points = even_points(lit.scene.mesh, 10, RandomStream(1, "points"));
    EXPECT_EQ(light.irradiance(points, 3, 64, 1, "test", Execution{}, effort), Values::Zero(10, 3));
    EXPECT_EQ(effort.segments, 0U);
}

TEST(DirectLight, ASunBelowTheHorizonOrBehindTheSurfaceIsDark) {
    const Lit lit(floor_with_screen(), {{Vec3(1, 0, 0), Rgb::Ones()}, {-Vec3::UnitZ(), Rgb::Ones()}});
    const DirectLight light(lit.scene, lit.visibility);
    DirectLight::Worker worker;
    EXPECT_TRUE((light.from_outside(lit.scene.mesh.at(0, 0.2, 0.2), worker) == 0.0).all());
}

/// A ball of facets with the normals of the sphere: the sun's irradiance is the cosine all over the lit half, also
/// where the facet itself looks away from the sun already.
TEST(DirectLight, ShadingNormalsFaceSunsThatTheirFacetsDoNot) {
    const Vec3 s = Vec3(1, 2, 3).normalized();
    const Lit lit(sphere(1.0, 3, Front::outside), {{s, Rgb::Ones()}});
    const DirectLight light(lit.scene, lit.visibility);
    DirectLight::Worker worker;
    int grazing = 0;
    for (SurfacePoint x : even_points(lit.scene.mesh, 5000, RandomStream(1, "points"))) {
        const Vec3 facet = x.normal;
        x.normal = x.position.normalized();
        const double cosine = x.normal.dot(s);
        grazing += cosine > 0.0 && facet.dot(s) < 0.0 ? 1 : 0;
        EXPECT_EQ(light.from_outside(x, worker)[0], cosine > 0.0 ? cosine : 0.0);
    }
    EXPECT_GT(grazing, 10);
}

TEST(DirectLight, SameBitsForAnyNumberOfThreads) {
    Lit lit(floor_with_screen(), {{Vec3(0.1, 0, 1).normalized(), Rgb(1, 2, 3)}});
    lit.scene.materials.resize(2);
    lit.scene.materials[1].emission = Rgb::Constant(5.0);
    add(lit.scene.mesh, rectangle(Vec3(1.4, 1.2, 3), Vec3(0, 0.5, 0), Vec3(0.5, 0, 0)), 1);
    lit.visibility.build(lit.scene.mesh);
    const DirectLight light(lit.scene, lit.visibility);
    EXPECT_EQ(light.area_light_materials(), (std::vector<char>{0, 1}));
    EXPECT_EQ(light.area_light_count(), 2U);
    EXPECT_EQ(light.rays_per_point(64), 65U);
    EXPECT_EQ(light.most_rays_per_point(64), 1U + 64 * AreaLights::most_rounds);
    const std::vector<SurfacePoint> points = even_points(lit.scene.mesh, 300, RandomStream(1, "points"));
    DirectLight::Effort effort, effort_of_three;
    const Values one = light.irradiance(points, 3, 16, 1, "test", Execution{1, nullptr}, effort);
    EXPECT_EQ(one, light.irradiance(points, 3, 16, 1, "test", Execution{3, nullptr}, effort_of_three));
    EXPECT_EQ(effort.segments, effort_of_three.segments);
    EXPECT_EQ(effort.clear, effort_of_three.clear);
    EXPECT_NE(one, light.irradiance(points, 3, 16, 2, "test", Execution{1, nullptr}, effort));
}

/// A wall beside a floor in the sun: one reflection brings rho times the floor's irradiance times its form factor.
TEST(DirectLight, TheFirstBounceIsGatheredWhereRaysHit) {
    const Vec3 s = Vec3(0, -1, 1).normalized();
    Mesh mesh = rectangle(Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 2, 0));
    add(mesh, rectangle(Vec3(0, 2, 0), Vec3(2, 0, 0), Vec3(0, 0, 2)), 0);
    const Lit lit(std::move(mesh), {{s, Rgb(1, 2, 3)}});
    const Mesh& m = lit.scene.mesh;
    const FirstBounce light(lit.scene, lit.visibility, std::make_shared<DirectLight>(lit.scene, lit.visibility), 0.5, 1,
                            Execution{});
    const SiteSet sites = test::poisson_sites(m, 0.5);
    const auto basis = test::plugin<Basis>("shepard");
    basis->bind(m, sites);
    constexpr std::size_t N = 4096;
    const Transport transport =
        gather(lit.scene, sites.points, *basis, lit.visibility, *test::plugin<Directions>("low-discrepancy"), N, 1,
               Execution{}, {{}, {&light}, 3});
    ASSERT_EQ(transport.bounce.size(), 1U);
    ASSERT_EQ(transport.bounce[0].rows(), std::ssize(sites.points));
    EXPECT_GT(transport.segments, 0U);
    for (std::size_t j = 0; j < sites.size(); ++j) {
        const SurfacePoint& x = sites.points[j];
        double exact = 0.0;
        for (Index t = 0; t < m.triangles.size(); ++t) {
            // The sun lights floor and wall wholly: nothing is in its way.
            exact += 0.5 * s.dot(m.normals[t]) *
                     lambert_form_factor(x.position, x.normal, m.corner(t, 0), m.corner(t, 1), m.corner(t, 2));
        }
        // Not worse than independent rays: a mean of N values in [0, 1/2 cos].
        EXPECT_NEAR(transport.bounce[0](static_cast<Eigen::Index>(j), 0), exact, 4.5 * 0.25 / std::sqrt(double(N)));
        // Sums of N terms in another rounding.
        EXPECT_NEAR(transport.bounce[0](static_cast<Eigen::Index>(j), 2),
                    3.0 * transport.bounce[0](static_cast<Eigen::Index>(j), 0), N * 0x1p-53);
    }
}

} // namespace
} // namespace difusa
