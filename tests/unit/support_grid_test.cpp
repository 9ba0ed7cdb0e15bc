#include "support/sanitized.h"

#include <difusa/core/error.h>
#include <difusa/discretisation/support_grid.h>

#include <support/rooms.h>
#include <support/sited.h>
#include <support/surface_sampling.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace difusa::support_grid_test {
namespace {

struct Case {
    std::string name;
    Mesh mesh;
    double spacing;
};

std::vector<Case> cases() {
    std::vector<Case> all;
    all.push_back({"cube", test::box(1.0), 0.1});
    all.push_back({"sphere", test::icosphere(3), 0.2});
    all.push_back({"needles", test::needles(1000), 0.1});
    all.push_back({"thin wall", test::thin_wall(1e-9), 0.1});
    all.push_back({"shelf over table", test::shelf_over_table(1e-7), 0.1});
    all.push_back({"a huge triangle beside tiny ones", test::huge_among_tiny(30, 0.05), 0.05});
    all.push_back({"Moebius strip", test::mobius(50), 0.1});
    all.push_back({"tiny", test::moved(test::icosphere(2), 1e-6, Vec3::Zero()), 2e-7});
    all.push_back({"large", test::moved(test::icosphere(2), 1e6, Vec3::Zero()), 2e5});
    all.push_back({"far away", test::moved(test::l_room(), 1.0, Vec3(1e6, -2e6, 5e5)), 0.15});
    return all;
}

/// Every site whose support holds x must be among the candidates; those of other regions must not.
void expect_complete(const Mesh& mesh, const SiteSet& sites, const std::vector<double>& support,
                     const std::vector<SurfacePoint>& probes) {
    const SupportGrid grid(mesh, sites, support);
    std::size_t missing = 0, foreign = 0, unsorted = 0;
    for (const SurfacePoint& x : probes) {
        const auto found = grid.near(x.position, mesh.region[x.face]);
        unsorted += std::is_sorted(found.begin(), found.end()) ? 0 : 1;
        for (const Index i : found) {
            foreign += sites.region[i] != mesh.region[x.face] ? 1 : 0;
        }
        for (Index i = 0; i < sites.size(); ++i) {
            if (sites.region[i] == mesh.region[x.face] && (x.position - sites.points[i].position).norm() < support[i]) {
                missing += std::binary_search(found.begin(), found.end(), i) ? 0 : 1;
            }
        }
    }
    EXPECT_EQ(missing, 0U);
    EXPECT_EQ(foreign, 0U);
    EXPECT_EQ(unsorted, 0U);
}

// Under the sanitizers the same supports, asked at fewer points.
const std::size_t random_probes = test::sanitized() ? 200 : 2000, special_probes = test::sanitized() ? 300 : 3000;

TEST(SupportGrid, MissesNoSiteThatReachesAPoint) {
    for (const Case& c : cases()) {
        SCOPED_TRACE(c.name);
        const SiteSet sites = test::poisson_sites(c.mesh, c.spacing);
        std::vector<SurfacePoint> probes = test::random_points(c.mesh, random_probes, RandomStream(4, "probes"));
        const auto special = test::special_points(c.mesh);
        probes.insert(probes.end(), special.begin(),
                      special.begin() + static_cast<std::ptrdiff_t>(std::min(special_probes, special.size())));
        for (const double width : {0.1, 1.0, 5.0}) {
            std::vector<double> support = sites.radius;
            for (double& r : support) {
                r *= width;
            }
            expect_complete(c.mesh, sites, support, probes);
        }
    }
}

TEST(SupportGrid, CopesWithSupportsOfAllSizesAtOnce) {
    const Mesh mesh = test::box(1.0, 2);
    const SiteSet sites = test::poisson_sites(mesh, 0.1);
    std::vector<double> support(sites.size());
    RandomStream random(2, "supports");
    for (double& s : support) {
        s = std::pow(10.0, -4.0 + 6.0 * random.uniform()); // from a thousandth of the spacing to all of the box
    }
    expect_complete(mesh, sites, support, test::random_points(mesh, 1000, RandomStream(5, "probes")));
}

TEST(SupportGrid, KnowsPlaceNormalAndReachOfItsCandidates) {
    const Mesh mesh = test::icosphere(1);
    const SiteSet sites = test::poisson_sites(mesh, 0.3);
    const SupportGrid grid(mesh, sites, sites.radius);
    for (Index i = 0; i < sites.size(); ++i) {
        const SupportGrid::Candidate& c = grid.candidate(i);
        EXPECT_EQ(Vec3(c.position[0], c.position[1], c.position[2]), sites.points[i].position);
        EXPECT_EQ(Vec3(c.normal[0], c.normal[1], c.normal[2]), sites.points[i].normal);
        EXPECT_EQ(c.support_squared, sites.radius[i] * sites.radius[i]);
    }
    EXPECT_TRUE(grid.near(Vec3(0, 0, 0), 0).empty()) << "the centre is not on the sphere";
}

/// Sites a hundred thousand times as dense as others, on a separate surface and on the same one: the work for each site
/// stays what it is for even ones, where supports of twice the cells' size overlap about 25 of them.
TEST(SupportGrid, IsAsLargeAsItsSitesAreMany) {
    const auto expect_small = [](const Mesh& mesh, const SiteSet& sites, const std::vector<double>& support) {
        const SupportGrid grid(mesh, sites, support);
        EXPECT_LE(grid.pair_count(), 100 * sites.size());
        expect_complete(mesh, sites, support, test::random_points(mesh, 300, RandomStream(5, "probes")));
    };
    const Mesh small = test::moved(test::grid(2, 2), 1e-5, Vec3(3, 0, 0)), large = test::grid(2, 2);
    const std::vector<SurfacePoint> dense = test::poisson_sites(small, 2e-7).points;
    std::vector<SurfacePoint> points = test::poisson_sites(large, 0.05).points;
    ASSERT_GT(dense.size(), points.size());
    const auto offset = static_cast<Index>(large.triangles.size());
    for (SurfacePoint each : dense) {
        each.face += offset;
        points.push_back(each);
    }
    const Mesh both = test::together(large, small);
    const SiteSet apart = make_site_set(both, points, 0.05, 8, Execution{1});
    expect_small(both, apart, apart.radius);
    points.resize(points.size() - dense.size());
    const double at = 0.3; // the same cluster on the large one
    for (const SurfacePoint& each : dense) {
        SurfacePoint moved = large.at(0, at, at);
        moved.u += each.position.x() - 3.0;
        moved.v += each.position.y();
        points.push_back(large.at(0, moved.u, moved.v));
    }
    const SiteSet within = make_site_set(large, points, 0.05, 8, Execution{1});
    expect_small(large, within, within.radius);
}

TEST(SupportGrid, RefusesSupportsThatAreNone) {
    const Mesh mesh = test::box(1.0);
    const SiteSet sites = test::poisson_sites(mesh, 0.3);
    for (const double wrong : {0.0, -1.0, std::numeric_limits<double>::infinity(), std::nan("")}) {
        std::vector<double> support = sites.radius;
        support.back() = wrong;
        EXPECT_THROW(SupportGrid(mesh, sites, support), UsageError) << wrong;
    }
}

} // namespace
} // namespace difusa::support_grid_test
