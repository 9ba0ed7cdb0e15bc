#include <difusa/core/error.h>
#include <difusa/discretisation/sampler.h>
#include <difusa/discretisation/site_set.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/rays/brute_force.h>
#include <difusa/rays/visibility.h>

#include <support/plugins.h>
#include <support/rooms.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace difusa::view_driven_test {
namespace {

std::vector<SurfacePoint> sample(const Mesh& mesh, const std::string& parameters, double spacing,
                                 std::size_t limit = 1'000'000, std::uint64_t seed = 1) {
    BruteForceVisibility visibility;
    visibility.build(mesh);
    const auto sampler = test::plugin<Sampler>("view-driven:" + parameters);
    EXPECT_TRUE(sampler->needs_visibility());
    return sampler->sample(mesh, &visibility, spacing, limit, RandomStream(seed, "sites"), Execution{});
}

double distance(const Mesh& mesh, const SurfacePoint& x, const SurfacePoint& y) {
    return site_distance(x.position, x.normal, mesh.region[x.face], y.position, y.normal, mesh.region[y.face]);
}

TEST(ViewDriven, PutsSitesOnTheFrontsThatAreSeenOnly) {
    // From above a cube that is seen from outside only its top is seen, and from it nothing.
    const Mesh cube = test::box(1.0);
    const auto sites = sample(cube, "eye=0.5/0.5/3,target=0.5/0.5/0,fov=60,grid=64", 0.1);
    EXPECT_GT(sites.size(), 60U);
    for (const SurfacePoint& x : sites) {
        EXPECT_EQ(x.normal, Vec3::UnitZ());
        EXPECT_NEAR(x.position.z(), 1.0, 1e-15);
    }
    // From the third cube of the L the walls of the first, around the corner, are seen by secondary rays only.
    const Mesh room = test::l_room();
    const auto hidden = [](const SurfacePoint& x) { return x.position.x() > 1.9 && x.normal.x() < -0.5; };
    const auto direct = sample(room, "eye=0.2/1.9/0.5,grid=64,passes=0", 0.1);
    const auto bounced = sample(room, "eye=0.2/1.9/0.5,grid=64,passes=4", 0.1);
    EXPECT_EQ(std::count_if(direct.begin(), direct.end(), hidden), 0);
    EXPECT_GT(std::count_if(bounced.begin(), bounced.end(), hidden), 10);
}

TEST(ViewDriven, PrunesByTheSpacing) {
    for (const auto& [mesh, eye] :
         std::vector<std::pair<Mesh, std::string>>{{test::l_room(), "eye=0.3/0.4/0.5"},
                                                   {test::icosphere(2, 1.0, true), "eye=0/0/0"},
                                                   {test::room_with_block(), "eye=0.1/0.1/0.1"},
                                                   {test::mobius(40), "eye=0/0/3"}}) {
        const auto sites = sample(mesh, "grid=64," + eye, 0.15);
        EXPECT_GT(sites.size(), 20U);
        for (std::size_t i = 0; i < sites.size(); ++i) {
            for (std::size_t j = 0; j < i; ++j) {
                ASSERT_GE(distance(mesh, sites[i], sites[j]), 0.15);
            }
        }
    }
}

TEST(ViewDriven, ChoosesAnObserverItself) {
    EXPECT_GT(sample(test::icosphere(2, 1.0, true), "grid=32", 0.3).size(), 20U) << "all around from within";
    EXPECT_GT(sample(test::icosphere(2), "grid=32", 0.3).size(), 5U) << "from outside";
}

TEST(ViewDriven, FollowsItsSeed) {
    const Mesh room = test::l_room();
    const auto a = sample(room, "grid=16,eye=0.3/0.4/0.5", 0.2, 1000, 5),
               b = sample(room, "grid=16,eye=0.3/0.4/0.5", 0.2, 1000, 5);
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        EXPECT_EQ(a[i].position, b[i].position);
    }
}

/// An observer that sees a ten-thousandth of the surface: a spacing that gives many sites there divides the rest into
/// millions.
TEST(ViewDriven, ChoosesNoSpacingFarTooFineForTheRest) {
    const Mesh room = test::l_room();
    BruteForceVisibility visibility;
    visibility.build(room);
    const auto sampler = test::plugin<Sampler>("view-driven:eye=0.3/0.4/0.5,target=0.3/0.4/0,fov=1,grid=64,passes=0");
    const double spacing = spacing_for_count(*sampler, room, &visibility, 1000, 1, Execution{});
    EXPECT_GE(spacing, std::sqrt(0.7 * room.area / 50'000.0) * (1.0 - 1e-12));
}

/// Rays are cast in batches, of which nothing is seen.
TEST(ViewDriven, TakesAnyNumberOfRays) {
    const Mesh cube = test::box(1.0);
    const std::string view = "eye=0.5/0.5/3,target=0.5/0.5/0,fov=60,passes=0,grid=512"; // 2^18 rays
    const auto sites = sample(cube, view, 0.1);
    EXPECT_GT(sites.size(), 60U);
    for (const SurfacePoint& x : even_points(cube, 500, RandomStream(1, "points"))) {
        const bool near = std::any_of(sites.begin(), sites.end(),
                                      [&](const SurfacePoint& site) { return distance(cube, x, site) < 0.105; });
        EXPECT_EQ(near, x.normal.z() > 0.5);
    }
}

TEST(ViewDriven, RefusesWhatCannotBe) {
    const Mesh cube = test::box(1.0);
    for (const char* wrong : {"target=1/2/3", "eye=1/2/3,target=1/2/3", "eye=1/2", "eye=1/2/3/4", "fov=0", "fov=180",
                              "grid=0", "spread=90", "passes=-1", "gird=12"}) {
        EXPECT_THROW(sample(cube, wrong, 0.1), UsageError) << wrong;
    }
    try {
        sample(cube, "eye=0.5/0.5/0.5", 0.1); // inside: backs all around
        FAIL() << "sites without a front";
    } catch (const InputError& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr("eye="));
    }
    EXPECT_THROW(sample(cube, "eye=5/0/0,target=9/0/0", 0.1), InputError) << "looks away";
    EXPECT_THROW(sample(test::l_room(), "grid=64,eye=0.3/0.4/0.5", 0.05, 10), ResourceError);
}

} // namespace
} // namespace difusa::view_driven_test
