// The bases of the classical method, `patch-constant` and `vertex-linear`, with their samplers.
#include <difusa/bake.h>
#include <difusa/core/error.h>
#include <difusa/discretisation/evaluate.h>
#include <difusa/discretisation/patch_mesh.h>
#include <difusa/import/shapes.h>

#include <meshes.h>
#include <support/furnace.h>
#include <support/rooms.h>
#include <support/sited.h>
#include <support/surface_sampling.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace difusa::patch_bases_test {
namespace {

using testing::HasSubstr;

SiteSet sites_of(const Mesh& mesh, const std::string& sampler, double spacing) {
    const Execution execution;
    return make_site_set(
        mesh,
        test::plugin<Sampler>(sampler)->sample(mesh, nullptr, spacing, 1'000'000, RandomStream(1, "sites"), execution),
        spacing, 10, execution);
}

/// A basis on its own sites.
struct Bound {
    Mesh mesh;
    SiteSet sites;
    std::shared_ptr<Basis> basis;

    Bound(const std::string& choice, Mesh on, double spacing)
        : mesh(std::move(on)), basis(test::plugin<Basis>(choice)) {
        sites = sites_of(mesh, basis->sampler(), spacing);
        basis->bind(mesh, sites);
    }
    Bound(const Bound&) = delete;
    Bound& operator=(const Bound&) = delete;

    Values at_sites(const std::function<double(const Vec3&)>& f) const {
        Values values(static_cast<Eigen::Index>(sites.size()), 1);
        for (std::size_t i = 0; i < sites.size(); ++i) {
            values(static_cast<Eigen::Index>(i), 0) = f(sites.points[i].position);
        }
        return values;
    }
};

std::vector<Mesh> some_meshes() {
    return {test::box(1.0),    test::l_room(), test::icosphere(2),         test::mobius(20),
            test::needles(30), test::book(5),  test::shelf_over_table(0.1)};
}

TEST(PatchMesh, FindsEveryPointInItsPatch) {
    for (const Mesh& mesh : some_meshes()) {
        const PatchMesh patches(mesh, 0.4, 1'000'000, Execution{});
        double area = 0.0;
        for (Index f = 0; f < patches.size(); ++f) {
            area += patches.area(f);
            EXPECT_EQ(patches.at(patches.centre(f)).patch, f);
        }
        EXPECT_NEAR(area, mesh.area, 1e-9 * mesh.area);
        for (const SurfacePoint& x : test::random_points(mesh, 500, RandomStream(2, "points"))) {
            const PatchMesh::Place place = patches.at(x);
            ASSERT_EQ(patches.parent(place.patch), x.face);
            Vec3 p = Vec3::Zero();
            for (std::size_t k = 0; k < 3; ++k) {
                EXPECT_GE(place.weight[k], 0.0);
                p += place.weight[k] * patches.vertex(patches.corners(place.patch)[k]).position;
            }
            // Coordinates of needles have the rounding errors of a division by their height, 1e-3 of their length.
            EXPECT_LT((p - x.position).norm(), 1e-9 * mesh.diameter());
        }
    }
}

TEST(PatchBases, InterpolateAtTheirSitesAndSumToOneEverywhere) {
    for (const char* const choice : {"patch-constant", "patch-constant:display=gouraud", "vertex-linear"}) {
        for (const Mesh& mesh : some_meshes()) {
            const Bound bound(choice, mesh, 0.2);
            BasisRow row;
            for (std::size_t j = 0; j < bound.sites.size(); ++j) {
                bound.basis->evaluate(bound.sites.points[j], row);
                double own = 0.0;
                for (std::size_t k = 0; k < row.element.size(); ++k) {
                    own += row.element[k] == j ? row.weight[k] : 0.0;
                }
                ASSERT_NEAR(own, 1.0, 1e-9) << choice;
            }
            for (const SurfacePoint& x : test::random_points(mesh, 200, RandomStream(3, "points"))) {
                bound.basis->evaluate(x, row);
                double sum = 0.0;
                for (const double weight : row.weight) {
                    EXPECT_GE(weight, 0.0);
                    sum += weight;
                }
                EXPECT_NEAR(sum, 1.0, 1e-12) << choice;
                bound.basis->display(x, row);
                sum = 0.0;
                for (const double weight : row.weight) {
                    sum += weight;
                }
                EXPECT_NEAR(sum, 1.0, 1e-12) << choice;
            }
        }
    }
}

/// Hat functions reproduce linear functions, on each flat side of a box up to its edges.
TEST(VertexLinear, ReproducesLinearFunctions) {
    const Bound bound("vertex-linear", test::box(1.0), 0.2);
    const auto f = [](const Vec3& x) { return 0.5 + x.x() - 2.0 * x.y() + 0.25 * x.z(); };
    const std::vector<SurfacePoint> points = test::random_points(bound.mesh, 500, RandomStream(4, "points"));
    const Values got = evaluate(*bound.basis, bound.at_sites(f), points, Execution{});
    for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_NEAR(got(static_cast<Eigen::Index>(i), 0), f(points[i].position), 1e-12);
    }
}

/// Rms error of an interpolated wave over the unit square.
double wave_error(const std::string& choice, double spacing, bool displayed) {
    const Bound bound(choice, rectangle(Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY()), spacing);
    const auto f = [](const Vec3& x) { return std::sin(4.0 * x.x() + 1.0) * std::cos(3.0 * x.y()); };
    const std::vector<SurfacePoint> points = test::random_points(bound.mesh, 4000, RandomStream(5, "points"));
    const Values coefficients = bound.at_sites(f);
    const Values got = displayed ? evaluate_display(*bound.basis, coefficients, points, Execution{})
                                 : evaluate(*bound.basis, coefficients, points, Execution{});
    double sum = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        sum += std::pow(got(static_cast<Eigen::Index>(i), 0) - f(points[i].position), 2);
    }
    return std::sqrt(sum / static_cast<double>(points.size()));
}

/// First order for patches, second for hats. Spacings halve the edges exactly, so that the meshes are similar; 4000
/// points know a ratio of rms to about 2 %, the order over a factor of 4 to 0.02, and the first mesh is coarse.
TEST(PatchBases, HaveTheirOrders) {
    const auto order = [](const std::string& choice, bool displayed) {
        return std::log(wave_error(choice, 0.05, displayed) / wave_error(choice, 0.0125, displayed)) / std::log(4.0);
    };
    EXPECT_NEAR(order("patch-constant", false), 1.0, 0.08);
    EXPECT_NEAR(order("vertex-linear", false), 2.0, 0.15);
    EXPECT_GT(order("patch-constant:display=gouraud", true), 1.4); // 2 inside, 3/2 for its border of first order
}

/// L 53, on the slide's square of four patches with the vertices a to i: the inner vertex has the mean, and at a border
/// the mean of it and the inner value is that of the patches there.
TEST(PatchConstant, ExtrapolatesToVerticesAsOnTheSlide) {
    // One fan of triangles around the middle of a square: each side's two corners share one patch with it.
    const Mesh mesh = test::make_mesh({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 0}},
                                      {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}});
    const Bound bound("patch-constant:display=gouraud", mesh, 1.0);
    ASSERT_EQ(bound.sites.size(), 4U);
    Values B(4, 1);
    for (std::size_t j = 0; j < 4; ++j) {
        B(static_cast<Eigen::Index>(j), 0) = std::vector<double>{1.0, 2.0, 4.0, 8.0}[bound.sites.points[j].face];
    }
    const std::vector<SurfacePoint> at{mesh.at(0, 0.0, 1.0), mesh.at(0, 0.0, 0.0), mesh.at(1, 0.0, 0.0)};
    const Values got = evaluate_display(*bound.basis, B, at, Execution{});
    EXPECT_DOUBLE_EQ(got(0, 0), 15.0 / 4.0);              // e = mean of all
    EXPECT_DOUBLE_EQ(0.5 * (got(1, 0) + got(0, 0)), 4.5); // (a + e)/2 = (B_1 + B_4)/2
    EXPECT_DOUBLE_EQ(0.5 * (got(2, 0) + got(0, 0)), 1.5); // (b + e)/2 = (B_1 + B_2)/2
}

TEST(PatchBases, AFurnaceIsExactWithThem) {
    for (const char* const choice : {"patch-constant", "patch-constant:display=gouraud", "vertex-linear"}) {
        BakeOptions options;
        options.spacing = 0.25;
        options.rays = 64;
        options.visibility = "cgal";
        options.basis = choice;
        options.solve.tolerance = 1e-12;
        const BakeResult result = test::baked(test::furnace(0.6, 2.0), options);
        EXPECT_EQ(result.options.sampler, test::plugin<Basis>(choice)->sampler());
        EXPECT_LT((result.solution.irradiance.array() - 5.0).abs().maxCoeff(), 1e-9) << choice;
        EXPECT_LT(result.error->total.high, 1e-8) << choice;
    }
}

/// The refinement is that of outputs, but what to do about it is not.
TEST(PatchBases, MoreSitesThanFitAreRefusedWithTheSpacing) {
    const Mesh mesh = test::box(Vec3(1, 1, 1), 1, true); // 12 triangles
    for (const std::string sampler : {"patch-centres", "mesh-vertices"}) {
        for (const double spacing : {0.1, 1e-9}) {
            EXPECT_THAT(
                [&] {
                    test::plugin<Sampler>(sampler)->sample(mesh, nullptr, spacing, 20, RandomStream(1, "sites"), {});
                },
                testing::ThrowsMessage<ResourceError>(
                    testing::AllOf(HasSubstr("give a larger --spacing"), testing::Not(HasSubstr("output")))))
                << sampler << ", " << spacing;
        }
    }
}

TEST(PatchBases, RefuseSitesThatAreNotTheirs) {
    const Mesh mesh = test::box(1.0);
    const SiteSet poisson = test::poisson_sites(mesh, 0.3);
    for (const char* const choice : {"patch-constant", "vertex-linear"}) {
        const auto basis = test::plugin<Basis>(choice);
        try {
            basis->bind(mesh, poisson);
            FAIL() << choice;
        } catch (const UsageError& error) {
            EXPECT_THAT(error.what(), HasSubstr("use --sampler " + basis->sampler()));
        }
        BakeOptions options;
        options.spacing = 0.3;
        options.basis = choice;
        options.sampler = "poisson-disk";
        EXPECT_THROW(test::baked(test::furnace(0.5, 1.0), options), UsageError);
        options.sampler.clear();
        options.adaptive = true; // patches alone are divided, and if they are shown flat
        options.basis = "vertex-linear";
        EXPECT_THROW(test::baked(test::furnace(0.5, 1.0), options), UsageError);
        options.basis = "patch-constant:display=gouraud";
        EXPECT_THROW(test::baked(test::furnace(0.5, 1.0), options), UsageError);
    }
}

} // namespace
} // namespace difusa::patch_bases_test
