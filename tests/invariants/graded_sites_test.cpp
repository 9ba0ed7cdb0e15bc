// Bakes whose sites are placed where they help (BakeOptions::adaptive).
#include <difusa/bake.h>
#include <difusa/import/shapes.h>
#include <difusa/mesh/nearest_surface.h>

#include <support/furnace.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace difusa::graded_sites_test {
namespace {

constexpr double edge_at = 1.0 / 3.0; ///< of the lid over the floor

/// The floor [0,1]² under an even sky of 1 W/m², with a black lid 0.1 above its part x < edge_at.
Scene floor_under_lid(double reflectance) {
    Scene scene;
    scene.mesh = rectangle(Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY());
    add(scene.mesh, rectangle(Vec3(-1.0, -1.0, 0.1), Vec3(1.0 + edge_at, 0, 0), Vec3(0, 3.0, 0)), 1);
    scene.materials.resize(2);
    scene.materials[0].name = "floor";
    scene.materials[0].reflectance = Rgb::Constant(reflectance);
    scene.materials[1].name = "lid";
    scene.materials[1].reflectance = Rgb::Zero();
    return scene;
}

BakeOptions graded(std::size_t sites) {
    BakeOptions options;
    options.adaptive = true;
    options.sites = sites;
    options.rays = 256;
    options.sky = Rgb::Ones();
    options.visibility = "cgal";
    options.error_points = 0;
    return options;
}

/// Sites of the floor less than 0.1 from the edge of the lid, over those more than 0.4 from it: 0.75, as the areas, if
/// they are evenly spaced.
double denser_at_edge(const BakeResult& result) {
    double near = 0.0, far = 0.0;
    for (const SurfacePoint& site : result.sites->points) {
        const double off = std::abs(site.position.x() - edge_at);
        near += site.position.z() == 0.0 && off < 0.1 ? 1.0 : 0.0;
        far += site.position.z() == 0.0 && off > 0.4 ? 1.0 : 0.0;
    }
    return near / far;
}

TEST(GradedSites, AreAsManyAsWanted) {
    for (const std::size_t sites : {500U, 2000U}) {
        const BakeResult result = test::baked(floor_under_lid(0.5), graded(sites));
        EXPECT_NEAR(static_cast<double>(result.sites->size()), static_cast<double>(sites),
                    0.05 * static_cast<double>(sites));
    }
}

TEST(GradedSites, AreDenseWhereTheLightVariesWhateverTheReflectance) {
    // A black floor sends nothing back, but its irradiance is looked at.
    for (const double reflectance : {0.5, 0.0}) {
        const BakeResult result = test::baked(floor_under_lid(reflectance), graded(1500));
        EXPECT_GT(denser_at_edge(result), 1.5) << reflectance; // twice as dense
        EXPECT_NEAR(static_cast<double>(result.sites->size()), 1500.0, 75.0) << reflectance;
    }
}

/// An attempt at an accuracy tells the next one where sites help, as long as it has enough of them.
TEST(GradedSites, AnAttemptStandsInForThePilotsOfTheNext) {
    BakeOptions options = graded(0);
    options.adaptive = false; // an ordered accuracy grades sites whatever this says
    options.error_points.reset();
    options.target.emplace();
    options.target->relative = 0.005;
    const BakeResult result = test::baked(floor_under_lid(0.5), options);
    EXPECT_GT(denser_at_edge(result), 2.0);
    ASSERT_GE(result.attempts.size(), 2U);
    std::ptrdiff_t pilots = 2;
    for (std::size_t k = 1; k < result.attempts.size(); ++k) {
        const Effort &before = result.attempts[k - 1].effort, &effort = result.attempts[k].effort;
        const double grown = static_cast<double>(effort.sites) / static_cast<double>(before.sites);
        ASSERT_GT(std::abs(grown - 3.0), 0.15) << "5 % off, sites tell nothing of what was wanted";
        pilots += grown > 3.0 ? 1 : 0; // never more than 8 times as many are wanted
    }
    const auto& phases = result.journal.seconds();
    EXPECT_EQ(
        std::count_if(phases.begin(), phases.end(), [](const auto& phase) { return phase.first == "pilot bake"; }),
        pilots);
}

/// Where evenly spaced sites are accurate enough, a second pilot would be in vain, however much grading would gain.
TEST(GradedSites, AreEvenWhereThatIsAccurateEnough) {
    BakeOptions options = graded(0);
    options.adaptive = false;
    options.error_points.reset();
    options.target.emplace();
    options.target->relative = 0.5;
    const BakeResult result = test::baked(floor_under_lid(0.5), options);
    EXPECT_EQ(result.attempts.size(), 1U);
    EXPECT_FALSE(result.sites->graded);
    const auto& savings = result.journal.savings();
    EXPECT_TRUE(std::any_of(savings.begin(), savings.end(), [](const Saving& s) {
        return s.what == "graded sites" && s.because == "evenly spaced sites are accurate enough";
    }));
}

/// Inside of a sphere whose wall emits alike everywhere all that differs from site to site is noise, which is normally
/// distributed: its mean square is pi/2 < 2 times the square of its mean size.
TEST(GradedSites, AreEvenWhereTheLightVariesNoMoreInOnePlaceThanInOthers) {
    Scene scene;
    scene.mesh = sphere(1.0, 6, Front::inside);
    scene.materials.resize(1);
    scene.materials[0].name = "wall";
    scene.materials[0].reflectance = Rgb::Constant(0.5);
    scene.materials[0].emission = Rgb::Ones();
    const BakeResult result = test::baked(scene, graded(300));
    EXPECT_FALSE(result.options.adaptive);
    EXPECT_FALSE(result.sites->graded);
    const auto& savings = result.journal.savings();
    EXPECT_EQ(std::count_if(savings.begin(), savings.end(), [](const Saving& s) { return s.what == "graded sites"; }),
              1);
    BakeOptions even = graded(300);
    even.adaptive = false;
    const BakeResult twin = test::baked(scene, even);
    ASSERT_EQ(twin.sites->size(), result.sites->size());
    EXPECT_EQ(twin.solution.h, result.solution.h);
}

/// A floor of 2 by 1 m under an even sky of 1 W/m², with black double-sided walls 0.1 m high across it every 0.1 m.
Scene floor_with_walls() {
    Scene scene;
    scene.mesh = rectangle(Vec3::Zero(), 2.0 * Vec3::UnitX(), Vec3::UnitY());
    for (int k = 1; k < 20; ++k) {
        add(scene.mesh, rectangle(Vec3(0.1 * k, 0, 0), Vec3::UnitY(), 0.1 * Vec3::UnitZ()), 1);
    }
    scene.materials.resize(2);
    scene.materials[0].name = "floor";
    scene.materials[0].reflectance = Rgb::Constant(0.5);
    scene.materials[1].name = "wall";
    scene.materials[1].reflectance = Rgb::Zero();
    scene.materials[1].double_sided = true;
    return scene;
}

/// The point of the floor, which is the first two triangles, at this place.
SurfacePoint on_floor(const Mesh& mesh, const Vec3& place) {
    for (const Index t : {0U, 1U}) {
        const auto weight = nearest_on_triangle(place, mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2));
        const SurfacePoint x = mesh.at(t, weight[1], weight[2]);
        if ((x.position - place).norm() < 1e-9) {
            return x;
        }
    }
    ADD_FAILURE() << "not on the floor: " << place.transpose();
    return {};
}

TEST(SitesInSight, AreInEveryBayBetweenWallsThatAreCloserThanTheSpacing) {
    for (const bool adaptive : {false, true}) {
        BakeOptions options = graded(0);
        options.adaptive = adaptive;
        options.spacing = 0.4;
        const BakeResult result = test::baked(floor_with_walls(), options);
        for (int k = 1; k < 19; ++k) {
            const SurfacePoint x = on_floor(result.scene->mesh, Vec3(0.1 * k + 0.05, 0.45, 0.0));
            const double H = result.field().evaluate({&x, 1}, 1, "bays", Execution{}).direct.sum();
            // The sky over the middle of a slot without ends is 1/sqrt(1 + (2 h / w)²) = 0.447 of all; they hide less
            // than the part of it lower than h over them, 0.45 away. Sites elsewhere in the bay have up to 0.55.
            EXPECT_GT(H / static_cast<double>(result.channels), 0.3) << k << (adaptive ? ", graded" : "");
            EXPECT_LT(H / static_cast<double>(result.channels), 0.7) << k << (adaptive ? ", graded" : "");
        }
    }
}

} // namespace
} // namespace difusa::graded_sites_test
