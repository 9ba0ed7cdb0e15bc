#include <difusa/discretisation/element_integrals.h>

#include <support/rooms.h>
#include <support/sited.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace difusa {
namespace {

double sum(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
}

TEST(ElementIntegrals, OfAPartitionOfUnitySumToTheArea) {
    for (const double scale : {1e-6, 1.0, 1e6}) {
        const Mesh mesh = test::moved(test::room_with_block(), scale, Vec3::Zero());
        const Scene scene = test::uniform_scene(mesh, 0.5, 1.0);
        const SiteSet sites = test::poisson_sites(scene.mesh, 0.15 * scale);
        for (const std::string& name : test::plugin_names<Basis>()) {
            const auto basis = test::plugin<Basis>(name);
            basis->bind(scene.mesh, sites);
            const ElementIntegrals integrals = element_integrals(scene, *basis, sites.spacing, Execution{});
            for (const double A : integrals.area) {
                EXPECT_GT(A, 0.0) << name;
            }
            if (basis->partition_of_unity()) {
                EXPECT_NEAR(sum(integrals.area), mesh.area, 1e-12 * mesh.area) << name;
                EXPECT_EQ(integrals.uncovered, 0.0);
            }
            // One material that emits: all of every element does.
            for (std::size_t i = 0; i < sites.size(); ++i) {
                ASSERT_EQ(integrals.share.row(i).column, std::vector<Index>{0});
                EXPECT_NEAR(integrals.share.row(i).value[0], 1.0, 1e-13);
            }
        }
    }
}

TEST(ElementIntegrals, OfAGaussianInAWidePlaneIsKnown) {
    // ∫ exp(-½ (r/s)²) dA up to 4 s is 2 pi s² (1 - e^-8). The midpoint rule on pieces of half the spacing is of second
    // order: relative error about (h/s)²/24 with h the piece's size, and s = 0.4 r, r = 2 spacings or so.
    const Mesh mesh = test::grid(1, 1);
    const Scene scene = test::uniform_scene(mesh, 0.5, 0.0);
    const SiteSet sites = test::poisson_sites(scene.mesh, 0.04);
    const auto basis = test::plugin<Basis>("radial");
    basis->bind(scene.mesh, sites);
    const ElementIntegrals integrals = element_integrals(scene, *basis, sites.spacing, Execution{});
    std::size_t inside = 0;
    for (std::size_t i = 0; i < sites.size(); ++i) {
        const double s = 0.4 * std::min(sites.radius[i], test::median_radius(sites));
        const Vec3 p = sites.points[i].position;
        if (std::min({p.x(), p.y(), 1 - p.x(), 1 - p.y()}) > 4 * s) {
            EXPECT_NEAR(integrals.area[i] / (2 * std::numbers::pi * s * s * (1 - std::exp(-8.0))), 1.0, 0.03);
            ++inside;
        }
    }
    EXPECT_GT(inside, 100U);
    EXPECT_EQ(integrals.share.nonzeros(), 0U) << "nothing emits";
}

TEST(ElementIntegrals, SharesAreThoseOfTheMaterials) {
    Mesh mesh = test::grid(2, 2);
    Scene scene = test::uniform_scene(mesh, 0.5, 0.0);
    scene.materials.resize(3, scene.materials[0]);
    scene.materials[1].emission = Rgb(1, 0, 0);
    scene.materials[2].emission = Rgb(0, 2, 0);
    scene.mesh.material = {0, 0, 1, 1, 2, 2, 1, 2};
    const SiteSet sites = test::poisson_sites(scene.mesh, 0.1);
    const auto basis = test::plugin<Basis>("normalized-radial");
    basis->bind(scene.mesh, sites);
    const ElementIntegrals integrals = element_integrals(scene, *basis, sites.spacing, Execution{});
    // Each material's shares, weighted by the elements' areas, sum to the area of its faces: 3 triangles of 1/8.
    std::vector<double> area(3, 0.0);
    for (std::size_t i = 0; i < sites.size(); ++i) {
        const SparseRows::Row& row = integrals.share.row(i);
        for (std::size_t k = 0; k < row.column.size(); ++k) {
            area[row.column[k]] += integrals.area[i] * row.value[k];
        }
    }
    EXPECT_EQ(area[0], 0.0);
    EXPECT_NEAR(area[1], 3.0 / 8.0, 1e-13);
    EXPECT_NEAR(area[2], 3.0 / 8.0, 1e-13);
}

TEST(ElementIntegrals, HaveTheSameBitsForAnyThreads) {
    const Scene scene = test::uniform_scene(test::icosphere(3), 0.5, 1.0);
    const SiteSet sites = test::poisson_sites(scene.mesh, 0.2);
    for (const std::string& name : test::plugin_names<Basis>()) {
        const auto basis = test::plugin<Basis>(name);
        basis->bind(scene.mesh, sites);
        const ElementIntegrals one = element_integrals(scene, *basis, 0.2, Execution{});
        for (const unsigned threads : {2U, 3U, 8U}) {
            const ElementIntegrals more = element_integrals(scene, *basis, 0.2, Execution{threads, nullptr});
            EXPECT_EQ(one.area, more.area) << name;
            for (std::size_t i = 0; i < sites.size(); ++i) {
                EXPECT_EQ(one.share.row(i).value, more.share.row(i).value);
            }
        }
    }
}

TEST(ElementIntegrals, SaysWhatNoElementCovers) {
    const Scene scene = test::uniform_scene(test::grid(1, 1), 0.5, 0.0);
    const SiteSet sites = test::poisson_sites(scene.mesh, 0.1);
    const auto basis = test::plugin<Basis>("radial:width=0.05");
    basis->bind(scene.mesh, sites);
    const ElementIntegrals integrals = element_integrals(scene, *basis, sites.spacing, Execution{});
    EXPECT_GT(integrals.uncovered, 0.1);
    EXPECT_LT(integrals.uncovered, 1.0);
}

} // namespace
} // namespace difusa
