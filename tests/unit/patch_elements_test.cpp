// Elements that are quarters of patches, where they are quartered, and the projection of their values to patches.
#include <difusa/core/error.h>
#include <difusa/discretisation/patch_elements.h>
#include <difusa/discretisation/projection.h>
#include <difusa/discretisation/subdivision.h>
#include <difusa/import/shapes.h>

#include <meshes.h>
#include <support/rooms.h>
#include <support/sited.h>
#include <support/surface_sampling.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <utility>
#include <vector>

namespace difusa::patch_elements_test {
namespace {

PatchMesh patches_on(const Mesh& mesh, double edge) {
    return {mesh, edge, 1'000'000, Execution{}};
}

/// Quarters random elements, down to any level.
void quarter_some(PatchElements& elements, int times) {
    RandomStream stream(7, "quarters");
    for (int k = 0; k < times; ++k) {
        const std::vector<Index> all = elements.elements();
        const Index node = all[stream.below(all.size())];
        if (elements.level(node) < PatchElements::most_levels) {
            elements.quarter(node);
        }
    }
}

std::vector<SurfacePoint> centres_of(const PatchElements& elements) {
    std::vector<SurfacePoint> centres;
    for (const Index node : elements.elements()) {
        centres.push_back(elements.centre(node));
    }
    return centres;
}

double area_of(const std::array<Vec3, 3>& v) {
    return 0.5 * (v[1] - v[0]).cross(v[2] - v[0]).norm();
}

/// How far a point is outside of a triangle in whose plane it is: 0 inside, else in barycentric coordinates.
double outside(const std::array<Vec3, 3>& v, const Vec3& x) {
    const double parts = area_of({x, v[1], v[2]}) + area_of({v[0], x, v[2]}) + area_of({v[0], v[1], x});
    return parts / area_of(v) - 1.0;
}

TEST(PatchElements, DivideTheSurface) {
    for (const Mesh& mesh : {test::box(1.0), test::icosphere(1), test::l_room(), test::mobius(10)}) {
        const PatchMesh patches = patches_on(mesh, 0.7);
        PatchElements elements(patches);
        quarter_some(elements, 200);
        const std::vector<Index> all = elements.elements();
        ASSERT_EQ(all.size(), elements.element_count());
        double area = 0.0;
        for (const Index node : all) {
            area += elements.area(node);
            EXPECT_NEAR(area_of(elements.corners(node)), elements.area(node), 1e-12 * mesh.area);
            EXPECT_EQ(elements.at(patches.at(elements.centre(node))), node);
        }
        EXPECT_NEAR(area, mesh.area, 1e-12 * mesh.area);
        for (const SurfacePoint& x : test::random_points(mesh, 300, RandomStream(3, "points"))) {
            const PatchMesh::Place place = patches.at(x);
            const Index found = elements.at(place);
            EXPECT_EQ(elements.patch(found), place.patch);
            EXPECT_LT(outside(elements.corners(found), x.position), 1e-7);
            // The naive twin: no other element of the patch has the point further inside.
            for (const Index node : all) {
                if (node != found && elements.patch(node) == place.patch) {
                    EXPECT_GT(outside(elements.corners(node), x.position), -1e-12);
                }
            }
        }
    }
}

TEST(PatchElements, FollowFromTheirCentres) {
    const Mesh mesh = test::l_room();
    const PatchMesh patches = patches_on(mesh, 0.7);
    PatchElements elements(patches);
    quarter_some(elements, 300);
    std::vector<SurfacePoint> centres = centres_of(elements);
    std::reverse(centres.begin(), centres.end());
    const PatchElements again(patches, centres);
    ASSERT_EQ(again.element_count(), elements.element_count());
    std::set<Index> sites;
    for (const Index node : again.elements()) {
        const Index twin = elements.at(patches.at(again.centre(node)));
        EXPECT_EQ(elements.level(twin), again.level(node));
        EXPECT_EQ(elements.centre(twin).position, again.centre(node).position);
        ASSERT_NE(again.site(node), none);
        EXPECT_LT((centres[again.site(node)].position - again.centre(node).position).norm(), 1e-12);
        sites.insert(again.site(node));
    }
    EXPECT_EQ(sites.size(), centres.size());

    std::vector<SurfacePoint> twice = centres;
    twice.push_back(twice.front());
    EXPECT_THROW(PatchElements(patches, twice), UsageError);
    std::vector<SurfacePoint> off = centres_of(PatchElements(patches));
    off.front() = patches.point(0, {0.4, 0.3, 0.3});
    EXPECT_THROW(PatchElements(patches, off), UsageError);
}

/// The rule of the edges' midpoints is exact for second degree, hence for the square of a linear function.
TEST(Subdivision, MeanSquareVariationIsThatOfALinearFunction) {
    const std::array<Vec3, 3> v{Vec3(0.2, -1.0, 0.5), Vec3(2.0, 0.3, 0.1), Vec3(0.7, 1.5, -0.4)};
    const Vec3 g(0.3, -0.8, 1.1), centre = (v[0] + v[1] + v[2]) / 3.0;
    double mean = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
        mean += std::pow(g.dot(0.5 * (v[k] + v[(k + 1) % 3]) - centre), 2) / 3.0;
    }
    EXPECT_NEAR(mean_square_variation(v, g), mean, 1e-14);
}

Values at_sites(const SiteSet& sites, const std::function<double(const Vec3&)>& f) {
    Values values(static_cast<Eigen::Index>(sites.size()), 1);
    for (std::size_t i = 0; i < sites.size(); ++i) {
        values(static_cast<Eigen::Index>(i), 0) = f(sites.points[i].position);
    }
    return values;
}

TEST(Subdivision, GradientsOfLinearFunctionsAreExact) {
    const Mesh mesh = rectangle(Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY());
    const PatchMesh patches = patches_on(mesh, 0.3);
    PatchElements elements(patches);
    quarter_some(elements, 30);
    const SiteSet sites = make_site_set(mesh, centres_of(elements), 0.1, 10, Execution{});
    const Values gradients =
        gradients_at(sites, at_sites(sites, [](const Vec3& x) { return 1.0 + 2.0 * x.x() - 3.0 * x.y(); }), {});
    for (Eigen::Index i = 0; i < gradients.rows(); ++i) {
        EXPECT_LT((Vec3(gradients.row(i).transpose()) - Vec3(2.0, -3.0, 0.0)).norm(), 1e-11);
    }
    EXPECT_EQ(gradients_at(sites, at_sites(sites, [](const Vec3&) { return 0.7; }), {}).norm(), 0.0);
}

TEST(Subdivision, StopsAtItsLimits) {
    const Mesh mesh = rectangle(Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY());
    const PatchMesh patches = patches_on(mesh, 0.5);
    const auto divided = [&](double miss, const SubdivisionLimits& limits) {
        const std::vector<SurfacePoint> centres = centres_of(PatchElements(patches));
        PatchElements elements(patches, centres);
        std::vector<double> misses(centres.size(), 0.0);
        misses[1] = miss;
        quarter_worst(elements, misses, limits);
        return elements;
    };
    const std::size_t n = patches.size();
    EXPECT_EQ(divided(1.0, {1000, 1, 0.0}).element_count(), n + 3);  // level
    EXPECT_EQ(divided(1.0, {1000, 3, 0.0}).element_count(), n + 63); // 4³ in place of one
    EXPECT_EQ(divided(1.0, {n + 11, 3, 0.0}).element_count(), n + 9);
    EXPECT_EQ(divided(1.0, {1, 3, 0.0}).element_count(), n); // more to begin with
    EXPECT_EQ(divided(0.0, {1000, 3, 0.0}).element_count(), n);
    // Per area, a quarter's mean square is a quarter of the whole's.
    const double mean_square = 1.0 / patches.area(0);
    EXPECT_EQ(divided(1.0, {1000, 3, 1.01 * mean_square}).element_count(), n);
    EXPECT_EQ(divided(1.0, {1000, 3, 0.26 * mean_square}).element_count(), n + 3);
    EXPECT_EQ(divided(1.0, {1000, 3, 0.24 * mean_square}).element_count(), n + 15);
}

/// Means over patches weighted by areas: they keep constants and the integral, and are their own means; transpose and
/// matrix are those of the same map.
TEST(Subdivision, PatchMeansAreAnAreaWeightedProjection) {
    const Mesh mesh = test::box(1.0);
    const double spacing = 0.2;
    const PatchMesh patches = patches_on(mesh, PatchMesh::edge_for_patches(PatchElements::coarseness * spacing));
    PatchElements elements(patches);
    quarter_some(elements, 60);
    SiteSet sites = make_site_set(mesh, centres_of(elements), spacing, 10, Execution{});
    sites.graded = true;
    const auto basis = test::plugin<Basis>("patch-constant");
    basis->bind(mesh, sites);
    ASSERT_NE(basis->substructure(), nullptr);
    const Substructure& parts = *basis->substructure();
    EXPECT_EQ(parts.patches(), patches.size());
    ProjectionChoice choice;
    choice.kind = ProjectionKind::substructured;
    const Projection projection(*basis, sites, choice, sites.points, parts.area, Execution{});
    EXPECT_TRUE(projection.is_mean());
    EXPECT_FALSE(projection.is_identity());

    const Values f = at_sites(sites, [](const Vec3& x) { return std::sin(9.0 * x.x()) + x.y() * x.z(); });
    const Values means = projection.coefficients(f);
    std::vector<double> integral(patches.size(), 0.0), of_means = integral, area = integral;
    for (std::size_t i = 0; i < sites.size(); ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        integral[parts.patch[i]] += parts.area[i] * f(row, 0);
        of_means[parts.patch[i]] += parts.area[i] * means(row, 0);
        area[parts.patch[i]] += parts.area[i];
    }
    for (Index p = 0; p < patches.size(); ++p) {
        EXPECT_NEAR(of_means[p], integral[p], 1e-14);
        EXPECT_NEAR(area[p], patches.area(p), 1e-14);
    }
    EXPECT_LT((projection.coefficients(means) - means).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_LT((projection.coefficients(Values::Ones(f.rows(), 1)).array() - 1.0).abs().maxCoeff(), 1e-14);

    const Values g = at_sites(sites, [](const Vec3& x) { return std::cos(5.0 * x.z()) - x.x(); });
    EXPECT_NEAR((projection.transposed(g).transpose() * f)(0, 0), (g.transpose() * means)(0, 0), 1e-12);
    const std::optional<SparseRows> matrix = projection.matrix();
    ASSERT_TRUE(matrix.has_value());
    Values product;
    matrix->apply(f, product, Execution{});
    EXPECT_LT((product - means).cwiseAbs().maxCoeff(), 1e-14);
}

} // namespace
} // namespace difusa::patch_elements_test
