#include <difusa/discretisation/discretisation.h>

#include <support/rooms.h>
#include <support/sited.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace difusa::element_integrals_test {
namespace {

double sum(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
}

TEST(ElementIntegrals, OfAPartitionOfUnitySumToTheArea) {
    for (const double scale : {1e-6, 1.0, 1e6}) {
        const Mesh mesh = test::moved(test::room_with_block(), scale, Vec3::Zero());
        const SiteSet sites = test::poisson_sites(mesh, 0.15 * scale);
        for (const std::string& name : test::plugin_names<Basis>()) {
            const auto basis = test::plugin<Basis>(name);
            basis->bind(mesh, sites);
            const std::vector<double> integrals = element_integrals(mesh, *basis, sites.spacing, Execution{});
            ASSERT_EQ(integrals.size(), sites.size());
            for (const double A : integrals) {
                EXPECT_GT(A, 0.0) << name;
            }
            if (basis->partition_of_unity()) {
                EXPECT_NEAR(sum(integrals), mesh.area, 1e-12 * mesh.area) << name;
            }
        }
    }
}

TEST(ElementIntegrals, OfAGaussianInAWidePlaneIsKnown) {
    // ∫ exp(-½ (r/s)²) dA up to 4 s is 2 pi s² (1 - e^-8). The midpoint rule on squares of side h = 0.7 spacing misses
    // what lies between the waves of the Gaussian and those of the grid, exp(-2 pi² (s/h)²) for each direction of the
    // grid, and what its cut at 4 s does: some of the e^-8 there. With s of 0.8 spacings or so that is next to nothing;
    // what is left comes from the triangles' diagonal, whose squares are cut: second order, (h/s)²/24.
    const Mesh mesh = test::grid(1, 1);
    const SiteSet sites = test::poisson_sites(mesh, 0.04);
    const auto basis = test::plugin<Basis>("radial");
    basis->bind(mesh, sites);
    const std::vector<double> integrals = element_integrals(mesh, *basis, sites.spacing, Execution{});
    std::size_t inside = 0;
    for (std::size_t i = 0; i < sites.size(); ++i) {
        const double s = 0.4 * std::min(sites.radius[i], test::median_radius(sites));
        const Vec3 p = sites.points[i].position;
        if (std::min({p.x(), p.y(), 1 - p.x(), 1 - p.y()}) > 4 * s) {
            EXPECT_NEAR(integrals[i] / (2 * std::numbers::pi * s * s * (1 - std::exp(-8.0))), 1.0, 0.03);
            ++inside;
        }
    }
    EXPECT_GT(inside, 100U);
}

TEST(ElementIntegrals, HaveTheSameBitsForAnyThreads) {
    const Mesh mesh = test::icosphere(3);
    const SiteSet sites = test::poisson_sites(mesh, 0.2);
    for (const std::string& name : test::plugin_names<Basis>()) {
        const auto basis = test::plugin<Basis>(name);
        basis->bind(mesh, sites);
        const std::vector<double> one = element_integrals(mesh, *basis, 0.2, Execution{});
        for (const unsigned threads : {2U, 3U, 8U}) {
            EXPECT_EQ(one, element_integrals(mesh, *basis, 0.2, Execution{threads, nullptr})) << name;
        }
    }
}

TEST(Discretisation, SaysWhatNoElementCovers) {
    const Mesh mesh = test::grid(1, 1);
    for (const bool narrow : {false, true}) {
        const Discretisation made =
            discretise(mesh, std::make_shared<SiteSet>(test::poisson_sites(mesh, 0.1)),
                       test::plugin<Basis>(narrow ? "radial:width=0.05" : "radial"), {}, false, 1, Execution{});
        if (narrow) {
            EXPECT_GT(made.uncovered, 0.1);
            EXPECT_LT(made.uncovered, 1.0);
        } else {
            EXPECT_EQ(made.uncovered, 0.0);
        }
        EXPECT_EQ(made.sites->area, made.integrals);
        EXPECT_EQ(made.surfels->edge(), Discretisation::surfel_edge(0.1));
    }
}

/// About three surfels a site, and some more where the sides of triangles are little longer than those of surfels: a
/// right triangle with a longest side of 1.45 edges makes two surfels of a quarter of a square each.
TEST(Discretisation, HasSurfelsSomewhatSmallerThanElements) {
    const auto expect = [](const Mesh& mesh, double spacing, double most) {
        const auto sites = static_cast<double>(test::poisson_sites(mesh, spacing).size());
        const Surfels surfels(mesh, Discretisation::surfel_edge(spacing), Execution{});
        // Disks of half the spacing about sites take at most 0.91 of a plane, squares of surfels all of it: at most
        // 0.91 / (pi/4) sites and at least 4 surfels for the square of a spacing.
        EXPECT_GE(static_cast<double>(surfels.size()), 4.0 * (std::numbers::pi / 4.0) / 0.91 * sites);
        EXPECT_LE(static_cast<double>(surfels.size()), most * sites);
    };
    expect(test::grid(1, 1), 0.02, 8.0);
    expect(test::l_room(), 0.06, 8.0);
    expect(test::box(1.0, 100), 0.035, 12.0);
    // Triangles a little larger than a surfel are cut in two both ways, and each of these cells again by the
    // hypotenuse: at most 6 times the 5.7 a site of a plane.
    expect(test::box(1.0, 40), 0.035, 34.2);
}

} // namespace
} // namespace difusa::element_integrals_test
