#include <difusa/core/error.h>
#include <difusa/discretisation/site_set.h>

#include <support/rooms.h>
#include <support/sited.h>
#include <support/surface_sampling.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace difusa::site_set_test {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

TEST(SiteDistance, IsTheEuclideanOneOverTheCosineOnOneRegion) {
    RandomStream random(1, "test");
    for (int i = 0; i < 1000; ++i) {
        const Vec3 p = test::random_direction(random), q = test::random_direction(random);
        const Vec3 n = test::random_direction(random), m = test::random_direction(random);
        const double d = site_distance(p, n, 4, q, m, 4);
        EXPECT_EQ(d, site_distance(q, m, 4, p, n, 4));
        EXPECT_GE(d, (p - q).norm() * (1.0 - 1e-15));
        if (n.dot(m) > perpendicular) {
            EXPECT_DOUBLE_EQ(d, (p - q).norm() / n.dot(m));
        } else {
            EXPECT_EQ(d, infinity);
        }
        EXPECT_EQ(site_distance(p, n, 4, q, n, 5), infinity);
    }
    EXPECT_EQ(site_distance(Vec3::Zero(), Vec3::UnitX(), 0, Vec3::UnitX(), Vec3::UnitY(), 0), infinity);
    EXPECT_EQ(site_distance(Vec3::Zero(), Vec3::UnitX(), 0, Vec3::Zero(), Vec3::UnitX(), 0), 0.0);
}

/// All pairs: the m-th smallest site distance, at most the diameter of the region, and never below the spacing.
void expect_radii(const Mesh& mesh, const SiteSet& sites) {
    std::vector<Vec3> low(mesh.region_count, mesh.high), high(mesh.region_count, mesh.low);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (int k = 0; k < 3; ++k) {
            const Vec3 p = mesh.corner(static_cast<Index>(t), k);
            low[mesh.region[t]] = low[mesh.region[t]].cwiseMin(p);
            high[mesh.region[t]] = high[mesh.region[t]].cwiseMax(p);
        }
    }
    const auto m = static_cast<std::size_t>(sites.neighbours);
    for (std::size_t i = 0; i < sites.size(); ++i) {
        ASSERT_EQ(sites.region[i], mesh.region[sites.points[i].face]);
        std::vector<double> distance;
        for (std::size_t j = 0; j < sites.size(); ++j) {
            const double d = site_distance(sites.points[i].position, sites.points[i].normal, sites.region[i],
                                           sites.points[j].position, sites.points[j].normal, sites.region[j]);
            if (j != i && d < infinity) {
                distance.push_back(d);
            }
        }
        std::sort(distance.begin(), distance.end());
        const double diameter = (high[sites.region[i]] - low[sites.region[i]]).norm();
        const double reach = distance.size() >= m ? std::min(distance[m - 1], diameter) : diameter;
        EXPECT_DOUBLE_EQ(sites.radius[i], std::max(reach, sites.spacing * (1.0 + 0x1p-10))) << "site " << i;
        EXPECT_DOUBLE_EQ(sites.area[i], std::numbers::pi * sites.radius[i] * sites.radius[i] / (sites.neighbours + 1));
    }
}

TEST(SiteSet, RadiiReachTheMthNeighbourOnAnySurface) {
    for (const int neighbours : {1, 4, 10}) {
        for (const Mesh& mesh :
             {test::box(1.0, 2), test::icosphere(0), test::icosphere(3, 1.0, true), test::mobius(60), test::needles(50),
              test::thin_wall(1e-6), test::shelf_over_table(1e-3), test::huge_among_tiny(8, 0.05), test::book(4)}) {
            expect_radii(mesh, test::poisson_sites(mesh, 0.2, 1, neighbours));
        }
    }
    expect_radii(test::moved(test::icosphere(2), 1e-6, Vec3(3, 4, 5)),
                 test::poisson_sites(test::moved(test::icosphere(2), 1e-6, Vec3(3, 4, 5)), 3e-7));
}

TEST(SiteSet, ATurnedBoxIsABox) {
    // Six walls with few sites each; rounding makes their cosines anything around zero.
    RandomStream random(6, "rotations");
    for (int i = 0; i < 20; ++i) {
        const double far = i % 2 == 0 ? 0.0 : 1e4;
        const Mesh mesh =
            test::transformed(test::box(1.0, 1, true), test::random_rotation(random), 1.0, far * Vec3(1, 2, 3));
        EXPECT_EQ(mesh.region_count, 6U);
        const SiteSet sites = test::poisson_sites(mesh, 0.4);
        for (std::size_t s = 0; s < sites.size(); ++s) {
            EXPECT_LE(sites.radius[s], std::sqrt(3.0) * std::sqrt(2.0)) << "the diagonal of a wall's bounding box";
        }
    }
}

TEST(SiteSet, KeepsThePointsInAnOrderOfPlace) {
    const Mesh mesh = test::box(1.0);
    std::vector<SurfacePoint> points = test::random_points(mesh, 500, RandomStream(3, "test"));
    const SiteSet sites = make_site_set(mesh, points, 0.01, 10, Execution{});
    std::reverse(points.begin(), points.end());
    const SiteSet again = make_site_set(mesh, points, 0.01, 10, Execution{3, nullptr});
    ASSERT_EQ(sites.size(), 500U);
    double along = 0.0;
    for (std::size_t i = 0; i < sites.size(); ++i) {
        EXPECT_EQ(sites.points[i].position, again.points[i].position);
        along += i == 0 ? 0.0 : (sites.points[i].position - sites.points[i - 1].position).norm();
        EXPECT_EQ(sites.radius[i], again.radius[i]);
    }
    // Two random points of a cube's surface are 0.9 apart in the mean.
    EXPECT_LT(along, 0.3 * 500);
}

TEST(SiteSet, ALoneSiteCoversItsRegion) {
    const Mesh mesh = test::box(Vec3(1, 2, 3));
    const SiteSet sites = make_site_set(mesh, {mesh.at(0, 0.1, 0.1)}, 1e-3, 10, Execution{});
    EXPECT_GE(sites.radius[0], Vec3(0, 2, 3).norm());
}

TEST(SiteSet, RefusesPointsThatAreNotOnTheSurface) {
    const Mesh mesh = test::box(1.0);
    const SurfacePoint sound = mesh.at(3, 0.2, 0.3);
    EXPECT_NO_THROW(make_site_set(mesh, {sound}, 0.1, 10, Execution{}));
    EXPECT_THROW(make_site_set(mesh, {}, 0.1, 10, Execution{}), UsageError);
    std::vector<SurfacePoint> wrong(4, sound);
    wrong[0].face = none;
    wrong[1].face = static_cast<Index>(mesh.triangles.size());
    wrong[2].position += Vec3(0.0, 1e-4, 0.0);
    wrong[3].position.x() = std::nan("");
    for (const SurfacePoint& each : wrong) {
        EXPECT_THROW(make_site_set(mesh, {sound, each}, 0.1, 10, Execution{}), UsageError);
    }
}

TEST(SiteSet, MeansAreBySitesAreas) {
    SiteSet sites;
    sites.points.resize(3);
    sites.area = {3.0, 1.0, -0.5}; // an integral of a function with negative parts counts as 0
    Values values(4, 2);           // the last row is of no site
    values << 1.0, 3.0, 10.0, 20.0, 1e9, 1e9, 1e9, 1e9;
    EXPECT_DOUBLE_EQ(sites.mean(values), (3.0 * 2.0 + 1.0 * 15.0) / 4.0);
    EXPECT_DOUBLE_EQ(sites.mean(std::vector<double>{2.0, 6.0, 1e9}), (3.0 * 2.0 + 6.0) / 4.0);
}

} // namespace
} // namespace difusa::site_set_test
