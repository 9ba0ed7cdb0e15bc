#include <difusa/discretisation/site_grid.h>

#include <difusa/core/error.h>

#include <support/rooms.h>
#include <support/surface_sampling.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <string>
#include <vector>

namespace difusa::site_grid_test {
namespace {

constexpr std::size_t no_limit = 1'000'000;

double distance(const Mesh& mesh, const SurfacePoint& x, const SurfacePoint& y) {
    return site_distance(x.position, x.normal, mesh.region[x.face], y.position, y.normal, mesh.region[y.face]);
}

/// What SiteGrid::insert promises, word for word.
void insert_one_by_one(const Mesh& mesh, double spacing, std::span<const Dart> darts,
                       std::vector<SurfacePoint>& sites) {
    std::vector<Dart> sorted(darts.begin(), darts.end());
    std::stable_sort(sorted.begin(), sorted.end(),
                     [](const Dart& a, const Dart& b) { return a.priority < b.priority; });
    for (const Dart& dart : sorted) {
        if (std::none_of(sites.begin(), sites.end(),
                         [&](const SurfacePoint& site) { return distance(mesh, dart.place, site) < spacing; })) {
            sites.push_back(dart.place);
        }
    }
}

std::vector<Dart> random_darts(const Mesh& mesh, std::size_t count, std::uint64_t seed, std::uint64_t priorities) {
    std::vector<Dart> darts;
    RandomStream stream(seed, "priorities");
    for (const SurfacePoint& x : test::random_points(mesh, count, RandomStream(seed, "darts"))) {
        darts.push_back({x, stream.below(priorities)});
    }
    return darts;
}

bool same_points(std::vector<SurfacePoint> a, std::vector<SurfacePoint> b) {
    const auto before = [](const SurfacePoint& x, const SurfacePoint& y) {
        return std::lexicographical_compare(x.position.begin(), x.position.end(), y.position.begin(), y.position.end());
    };
    std::sort(a.begin(), a.end(), before);
    std::sort(b.begin(), b.end(), before);
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](const SurfacePoint& x, const SurfacePoint& y) { return x.position == y.position; });
}

struct Case {
    std::string name;
    Mesh mesh;
    double spacing;
};

std::vector<Case> cases() {
    return {{"cube", test::box(1.0, 2), 0.1},
            {"one disc covers a wall", test::box(1.0), 3.0}, // hundreds of darts in each other's way
            {"sphere", test::icosphere(2), 0.15},
            {"coarse sphere", test::icosphere(0), 0.3},
            {"thin wall", test::thin_wall(1e-9), 0.1},
            {"Moebius strip", test::mobius(50), 0.1},
            {"large and far away", test::moved(test::l_room(), 1e6, Vec3(3e9, -1e9, 2e9)), 2e5}};
}

TEST(SiteGrid, AcceptsTheDartsThatSerialDartThrowingAccepts) {
    for (const Case& c : cases()) {
        SCOPED_TRACE(c.name);
        // Equal priorities too: the first in the list goes first.
        for (const std::uint64_t priorities : {std::uint64_t{1}, std::uint64_t{20}, ~std::uint64_t{0}}) {
            SiteGrid grid(c.mesh, c.spacing, no_limit), parallel(c.mesh, c.spacing, no_limit);
            std::vector<SurfacePoint> sites;
            for (std::uint64_t lot = 0; lot < 3; ++lot) {
                const std::vector<Dart> darts = random_darts(c.mesh, 700 << lot, lot, priorities);
                insert_one_by_one(c.mesh, c.spacing, darts, sites);
                grid.insert(darts, Execution{});
                parallel.insert(darts, Execution{3, nullptr});
                EXPECT_TRUE(same_points(grid.sites(), sites));
                ASSERT_EQ(parallel.sites().size(), grid.sites().size());
                for (std::size_t i = 0; i < grid.sites().size(); ++i) {
                    EXPECT_EQ(parallel.sites()[i].position, grid.sites()[i].position) << "another order";
                }
            }
        }
    }
}

TEST(SiteGrid, FindsConflictsAsAllPairsDo) {
    for (const Case& c : cases()) {
        SCOPED_TRACE(c.name);
        SiteGrid grid(c.mesh, c.spacing, no_limit);
        grid.insert(random_darts(c.mesh, 400, 1, ~std::uint64_t{0}), Execution{});
        std::vector<SurfacePoint> probes = test::random_points(c.mesh, 1000, RandomStream(2, "probes"));
        const std::vector<SurfacePoint> special = test::special_points(c.mesh);
        probes.insert(probes.end(), special.begin(), special.end());
        for (const SurfacePoint& x : probes) {
            double nearest = std::numeric_limits<double>::infinity();
            for (const SurfacePoint& site : grid.sites()) {
                nearest = std::min(nearest, distance(c.mesh, x, site));
            }
            EXPECT_EQ(grid.conflicts(x), nearest < c.spacing) << nearest;
        }
    }
}

TEST(SiteGrid, HoldsNoMoreThanItsLimit) {
    const Mesh mesh = test::box(1.0);
    const std::vector<Dart> darts = random_darts(mesh, 500, 1, ~std::uint64_t{0});
    std::vector<SurfacePoint> sites;
    insert_one_by_one(mesh, 0.2, darts, sites);
    EXPECT_NO_THROW(SiteGrid(mesh, 0.2, sites.size()).insert(darts, Execution{}));
    EXPECT_THROW(SiteGrid(mesh, 0.2, sites.size() - 1).insert(darts, Execution{}), ResourceError);
    EXPECT_THROW(SiteGrid(mesh, 1e-12, no_limit), ResourceError) << "cells cannot be counted";
}

} // namespace
} // namespace difusa::site_grid_test
