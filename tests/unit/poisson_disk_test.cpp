#include <difusa/core/error.h>
#include <difusa/discretisation/sampler.h>

#include <support/plugins.h>
#include <support/rooms.h>
#include <support/surface_sampling.h>

#include <difusa/discretisation/site_set.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

namespace difusa::poisson_disk_test {
namespace {

constexpr std::size_t no_limit = 1'000'000;

std::vector<SurfacePoint> sample(const Mesh& mesh, double spacing, std::uint64_t seed = 1) {
    return test::plugin<Sampler>("poisson-disk")
        ->sample(mesh, nullptr, spacing, no_limit, RandomStream(seed, "sites"), Execution{});
}

double distance(const Mesh& mesh, const SurfacePoint& x, const SurfacePoint& y) {
    return site_distance(x.position, x.normal, mesh.region[x.face], y.position, y.normal, mesh.region[y.face]);
}

double to_nearest(const Mesh& mesh, const std::vector<SurfacePoint>& sites, const SurfacePoint& x) {
    double least = std::numeric_limits<double>::infinity();
    for (const SurfacePoint& site : sites) {
        least = std::min(least, distance(mesh, x, site));
    }
    return least;
}

struct Case {
    std::string name;
    Mesh mesh;
    double spacing;
    std::vector<SurfacePoint> sites;
};

/// Flat, curved, thin and badly triangulated.
std::vector<Case> make_cases() {
    std::vector<Case> all;
    all.push_back({"wall of two triangles", test::grid(1, 1), 0.07, {}});
    all.push_back({"wall of many triangles", test::grid(60, 60), 0.09, {}});
    all.push_back({"cube", test::box(1.0, 3), 0.15, {}});
    all.push_back({"long thin box", test::box(Vec3(10, 0.01, 0.01)), 0.05, {}});
    all.push_back({"thin wall", test::thin_wall(1e-9), 0.1, {}});
    all.push_back({"coarse sphere", test::icosphere(0), 0.2, {}});
    all.push_back({"sphere of facets above the spacing", test::icosphere(1), 0.15, {}});
    all.push_back({"fine sphere", test::icosphere(4), 0.2, {}});
    all.push_back({"needles", test::needles(400), 0.08, {}});
    all.push_back({"a huge triangle beside tiny ones", test::huge_among_tiny(40, 0.1), 0.06, {}});
    all.push_back({"Moebius strip", test::mobius(80), 0.12, {}});
    all.push_back({"shelf over table", test::shelf_over_table(1e-4), 0.11, {}});
    all.push_back({"book", test::book(7), 0.15, {}});
    all.push_back({"room with block", test::room_with_block(), 0.13, {}});
    all.push_back({"smaller than the spacing", test::icosphere(1, 0.01), 1.0, {}});
    all.push_back({"tiny", test::moved(test::l_room(), 1e-6, Vec3::Zero()), 2e-7, {}});
    all.push_back({"large and far away", test::moved(test::l_room(), 1e6, Vec3(3e9, -1e9, 2e9)), 2e5, {}});
    for (Case& c : all) {
        c.sites = sample(c.mesh, c.spacing);
    }
    return all;
}

const std::vector<Case>& cases() {
    static const std::vector<Case> all = make_cases();
    return all;
}

TEST(PoissonDisk, NoTwoSitesAreCloserThanTheSpacing) {
    for (const Case& c : cases()) {
        SCOPED_TRACE(c.name);
        const std::vector<SurfacePoint>& sites = c.sites;
        std::size_t too_close = 0;
        for (std::size_t i = 0; i < sites.size(); ++i) {
            for (std::size_t j = 0; j < i; ++j) {
                too_close += distance(c.mesh, sites[i], sites[j]) < c.spacing ? 1 : 0;
            }
        }
        EXPECT_EQ(too_close, 0U) << sites.size() << " sites";
    }
}

TEST(PoissonDisk, NoPointOfTheSurfaceIsFartherThanTheSpacing) {
    for (const Case& c : cases()) {
        SCOPED_TRACE(c.name);
        const std::vector<SurfacePoint>& sites = c.sites;
        std::vector<SurfacePoint> probes = test::random_points(c.mesh, 8000, RandomStream(9, "probes"));
        const std::vector<SurfacePoint> special = test::special_points(c.mesh);
        probes.insert(probes.end(), special.begin(), special.end());
        double farthest = 0.0;
        for (const SurfacePoint& x : probes) {
            farthest = std::max(farthest, to_nearest(c.mesh, sites, x));
        }
        EXPECT_LE(farthest, c.spacing * (1.0 + 0x1p-20));
        EXPECT_GT(farthest, c.spacing * 0.5 * (sites.size() > c.mesh.region_count ? 1.0 : 0.0))
            << "denser than asked for";
    }
}

TEST(PoissonDisk, SitesLieOnTheSurfaceAndEveryRegionHasOne) {
    for (const Case& c : cases()) {
        SCOPED_TRACE(c.name);
        std::vector<int> count(c.mesh.region_count, 0);
        for (const SurfacePoint& x : c.sites) {
            ASSERT_LT(x.face, c.mesh.triangles.size());
            ++count[c.mesh.region[x.face]];
            EXPECT_TRUE(x.u >= 0.0 && x.v >= 0.0 && x.u + x.v <= 1.0 + 1e-15) << x.u << " " << x.v;
            EXPECT_EQ(x.position, c.mesh.at(x.face, x.u, x.v).position);
            EXPECT_EQ(x.normal, c.mesh.normals[x.face]);
        }
        for (const int n : count) {
            EXPECT_GT(n, 0);
        }
    }
}

TEST(PoissonDisk, FollowsItsSeedAndNothingElse) {
    const Mesh mesh = test::icosphere(2);
    const auto a = sample(mesh, 0.2, 7), b = sample(mesh, 0.2, 7), other = sample(mesh, 0.2, 8);
    ASSERT_EQ(a.size(), b.size());
    std::size_t equal = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        EXPECT_EQ(a[i].position, b[i].position);
        equal += i < other.size() && a[i].position == other[i].position ? 1 : 0;
    }
    EXPECT_EQ(equal, 0U);
    // Scaled by a power of two the same darts fall on the same places.
    const auto large = sample(test::moved(mesh, 1024.0, Vec3::Zero()), 0.2 * 1024.0, 7);
    ASSERT_EQ(large.size(), a.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        EXPECT_EQ(large[i].position, 1024.0 * a[i].position);
    }
}

/// Sites of a triangulation fall on equal areas alike: counts in cells far larger than the spacing vary less than those
/// of independent points.
TEST(PoissonDisk, IsEvenWhateverTheTriangles) {
    for (const Mesh& mesh : {test::grid(1, 1), test::grid(37, 53), test::needles(60)}) {
        std::vector<int> count(16, 0);
        double total = 0.0;
        for (const SurfacePoint& x : sample(mesh, 0.02)) {
            const auto cell = [](double p) { return std::min<std::size_t>(3, static_cast<std::size_t>(4.0 * p)); };
            ++count[4 * cell(x.position.x()) + cell(x.position.y())];
            total += 1.0;
        }
        for (const int n : count) {
            // Border cells have more, by half a row of sites along their sides.
            EXPECT_NEAR(n, total / 16, 3.0 * std::sqrt(total / 16)) << total;
        }
    }
}

TEST(PoissonDisk, DoesNotDependOnTheNumberOfThreads) {
    for (const Mesh& mesh : {test::icosphere(3), test::room_with_block(), test::huge_among_tiny(40, 0.1)}) {
        const auto one = sample(mesh, 0.04);
        const auto three = test::plugin<Sampler>("poisson-disk")
                               ->sample(mesh, nullptr, 0.04, no_limit, RandomStream(1, "sites"), Execution{3, nullptr});
        ASSERT_EQ(one.size(), three.size());
        for (std::size_t i = 0; i < one.size(); ++i) {
            EXPECT_EQ(one[i].position, three[i].position);
            EXPECT_EQ(one[i].face, three[i].face);
        }
    }
}

/// Darts that are accepted wherever there is room, evenly, are random sequential adsorption of discs of diameter D:
/// these jam at a coverage of 0.54707 (Wang 1994; Zhang and Torquato 2013).
TEST(PoissonDisk, IsAsDenseAsRandomSequentialAdsorption) {
    for (const Mesh& mesh : {test::grid(1, 1), test::grid(40, 40), test::needles(60)}) {
        const double spacing = 0.005;
        std::size_t inside = 0;
        for (const SurfacePoint& x : sample(mesh, spacing)) { // away from the border, where sites are denser
            inside += (x.position.head<2>().array() - 0.5).abs().maxCoeff() < 0.475 ? 1 : 0;
        }
        const double coverage =
            static_cast<double>(inside) * std::numbers::pi / 4.0 * spacing * spacing / (0.95 * 0.95);
        // 25000 discs: the standard deviation is below 0.25 / sqrt(25000) = 0.16 % of the coverage.
        EXPECT_NEAR(coverage, 0.54707, 0.008 * 0.54707);
    }
}

TEST(PoissonDisk, StopsAtTheLimit) {
    const Mesh mesh = test::box(1.0);
    const auto sampler = test::plugin<Sampler>("poisson-disk");
    const std::size_t needed = sample(mesh, 0.1).size();
    const auto sampled = [&](std::size_t limit) {
        return sampler->sample(mesh, nullptr, 0.1, limit, RandomStream(1, "sites"), Execution{}).size();
    };
    EXPECT_THROW(sampled(needed / 2), ResourceError);
    EXPECT_THROW(sampled(0), ResourceError);
    EXPECT_EQ(sampled(2 * needed), sampled(4 * needed));
    // A spacing that would need more sites than there are atoms ends at the limit, soon.
    EXPECT_THROW(sampler->sample(mesh, nullptr, 1e-9, 1000, RandomStream(1, "sites"), Execution{}), ResourceError);
}

class Cancelled : public Progress {
    bool cancelled() const override { return true; }
};

TEST(PoissonDisk, CanBeInterrupted) {
    Cancelled progress;
    EXPECT_THROW(
        test::plugin<Sampler>("poisson-disk")
            ->sample(test::box(1.0), nullptr, 0.1, no_limit, RandomStream(1, "sites"), Execution{1, &progress}),
        Interrupted);
}

TEST(SpacingForCount, GivesTheCountWithinFivePercent) {
    const auto sampler = test::plugin<Sampler>("poisson-disk");
    for (const Mesh& mesh : {test::box(1.0), test::icosphere(3, 2.5), test::moved(test::l_room(), 1e-6, Vec3::Zero()),
                             test::needles(100), test::box(Vec3(10, 0.1, 0.1))}) {
        for (const std::size_t count : {250U, 1500U}) {
            const double spacing = spacing_for_count(*sampler, mesh, nullptr, count, 1, Execution{});
            const auto found = static_cast<double>(sample(mesh, spacing).size());
            EXPECT_NEAR(found, static_cast<double>(count), 0.05 * static_cast<double>(count));
        }
    }
}

/// 96 little cubes, 576 regions.
Mesh little_cubes() {
    Mesh mesh = test::box(0.01);
    for (int i = 1; i < 96; ++i) {
        mesh = test::together(mesh, test::moved(test::box(0.01), 1.0, Vec3(i, 0, 0)));
    }
    return mesh;
}

TEST(SpacingForCount, EndsWhereNoSpacingGivesTheCount) {
    const Mesh mesh = little_cubes();
    const double spacing = spacing_for_count(*test::plugin<Sampler>("poisson-disk"), mesh, nullptr, 50, 1, Execution{});
    EXPECT_NEAR(static_cast<double>(sample(mesh, spacing).size()), 576 + 25, 0.05 * (576 + 25));
}

/// Also where the single sites are just fewer than those that are wanted: 576 on the little cubes, and 6 on the large
/// one, which has the others.
TEST(SpacingForCount, LeavesHalfOfTheSitesForLargeRegionsWhereSmallOnesTakeMoreThanHalf) {
    const Mesh mesh = test::together(little_cubes(), test::moved(test::box(1.0), 1.0, Vec3(0, 5, 0)));
    for (const std::size_t count : {400U, 600U, 1000U, 1200U, 2400U}) {
        const double spacing =
            spacing_for_count(*test::plugin<Sampler>("poisson-disk"), mesh, nullptr, count, 1, Execution{});
        const auto wanted = static_cast<double>(std::max<std::size_t>(count, 576 + 6 + count / 2));
        const std::vector<SurfacePoint> sites = sample(mesh, spacing);
        EXPECT_NEAR(static_cast<double>(sites.size()), wanted, 0.05 * wanted);
        const auto little =
            std::count_if(sites.begin(), sites.end(), [](const SurfacePoint& x) { return x.position.y() < 1.0; });
        EXPECT_EQ(little, 576);
    }
}

TEST(SpacingForCount, CoversLongNeedlesWithFewSites) {
    // A fan 1 long and 1e-7 wide: one site covers 2 D of its length, not pi D² of its area.
    std::vector<Vec3> points{Vec3::Zero()};
    std::vector<std::array<Index, 3>> triangles;
    for (Index i = 0; i <= 100; ++i) {
        points.emplace_back(std::cos(1e-9 * i), std::sin(1e-9 * i), 0.0);
        if (i > 0) {
            triangles.push_back({0, i, i + 1});
        }
    }
    const Mesh fan = test::make_mesh(std::move(points), std::move(triangles));
    const double spacing = spacing_for_count(*test::plugin<Sampler>("poisson-disk"), fan, nullptr, 200, 1, Execution{});
    EXPECT_GT(spacing, 0.5 / 200);
    EXPECT_NEAR(static_cast<double>(sample(fan, spacing).size()), 200.0, 10.0);
}

/// Coordinates of 1e14 are multiples of 1/64.
TEST(PoissonDisk, NeedsCoordinatesFinerThanTheSpacing) {
    const Mesh far = test::moved(test::box(1.0), 1.0, Vec3::Constant(1e14));
    try {
        sample(far, 0.1);
        FAIL() << "sites a few steps apart";
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("move it to the origin"), std::string::npos) << error.what();
    }
    EXPECT_GT(sample(test::moved(test::box(1.0), 1.0, Vec3::Constant(1e12)), 0.1).size(), 300U);
    EXPECT_GT(sample(test::moved(test::box(1e3), 1.0, Vec3::Constant(1e14)), 100.0).size(), 300U);
}

} // namespace
} // namespace difusa::poisson_disk_test
