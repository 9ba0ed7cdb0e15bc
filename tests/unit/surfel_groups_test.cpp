// Groups of surfels: their moments, and how far form factors and slopes of kernels err, surfel by surfel.
#include <difusa/import/shapes.h>
#include <difusa/rays/lambert.h>
#include <difusa/transport/analytic_factors.h>

#include <support/discretised.h>
#include <support/group_factors.h>
#include <support/rooms.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace difusa::surfel_groups_test {
namespace {

using test::Discretised;
using test::sum_of;

/// The form factors of all surfels times b, one by one: nothing is in between.
double surfel_by_surfel(const Discretised& made, const SurfacePoint& x, const Values& b) {
    const Mesh& mesh = made.scene.mesh;
    const Surfels& surfels = *made.discretisation.surfels;
    const SurfacePoint from = inset(mesh, x);
    std::vector<Surfels::Piece> pieces;
    double sum = 0.0;
    for (Index s = 0; s < surfels.size(); ++s) {
        surfels.pieces(s, pieces);
        for (const Surfels::Piece& piece : pieces) {
            std::vector<Vec3> corners;
            for (std::size_t k = 0; k < piece.outline.count; ++k) {
                const Eigen::Vector2d& uv = piece.outline.corner[k];
                corners.push_back(mesh.at(piece.triangle, uv[0], uv[1]).position);
            }
            sum += mesh.normals[piece.triangle] == x.normal
                       ? 0.0
                       : b(s, 0) * lambert_form_factor(from.position, x.normal, corners);
        }
    }
    return sum;
}

/// The surfels of each group.
std::vector<std::vector<Index>> members_of(const SurfelGroups& groups) {
    std::vector<std::vector<Index>> members(groups.size());
    for (Index g = 0; g < groups.size(); ++g) {
        if (groups[g].second == none) {
            members[g] = {groups[g].first};
            continue;
        }
        for (const Index half : {groups[g].first, groups[g].second}) {
            members[g].insert(members[g].end(), members[half].begin(), members[half].end());
        }
    }
    return members;
}

/// Light from 0 to 1.
template <class Light> Values light_on(const Discretised& made, const Light& light) {
    const Surfels& surfels = *made.discretisation.surfels;
    Values b = made.on_surfels(0.0);
    std::vector<Surfels::Piece> pieces;
    for (Index s = 0; s < surfels.size(); ++s) {
        b(s, 0) = light(surfels.centre(s, pieces).position);
    }
    return b;
}

TEST(AnalyticFactors, GroupsErrLessThanRays) {
    // The kernel has its mean over each group, so that light in 0 to 1 errs by at most half of what the kernel is from
    // linear: sqrt(F / N) / 16 for N independent rays, whose noise sqrt(N) / 8 times fewer even ones have.
    const Discretised made(test::uniform_scene(test::box(1.0, 1, true), 0.5, 0.0), 0.2, "cgal", "shepard");
    constexpr double even = 1024, N = even * 4;
    const AnalyticFactors factors(made.scene.mesh, *made.discretisation.surfels, static_cast<std::size_t>(even),
                                  Execution{});
    const Vec3 middle = Vec3::Constant(0.5);
    const std::array<Values, 2> lights{
        light_on(made, [](const Vec3& y) { return 0.5 + 0.5 * std::sin(9.0 * y.sum()); }),
        // Greatest where the kernel of what is opposite is greatest, as light often is.
        light_on(made, [&](const Vec3& y) { return std::exp(-8.0 * ((y - middle).squaredNorm() - 0.25)); })};
    AnalyticFactors::Worker worker;
    std::vector<AnalyticFactors::Factor> found;
    std::size_t entries = 0;
    for (const SurfacePoint& x : made.discretisation.points) {
        factors.find(x, found, worker);
        double bound = 1e-9, whole = 0.0;
        for (const auto& [group, factor, slope] : found) {
            bound += std::sqrt(factor / N) / 16.0;
            whole += factor;
        }
        entries += found.size();
        EXPECT_NEAR(whole, 1.0, 1e-9);
        for (const Values& b : lights) {
            EXPECT_NEAR(sum_of(factors, found, b), surfel_by_surfel(made, x, b), bound);
        }
    }
    EXPECT_LT(entries, made.discretisation.points.size() * 1024); // fewer than rays
}

/// No group errs by more than its share, whatever the light: not by that of the sign of what a linear kernel is off by.
TEST(AnalyticFactors, EachGroupErrsLessThanItsRays) {
    constexpr double even = 512, N = even * 2.8284271247461903;
    // A triangle and a rectangle, of which a square grid cuts off corners, 1 above a floor.
    Mesh triangle, oblong;
    triangle.points = {Vec3(0, 0, 1), Vec3(0.5, 3, 1), Vec3(3, 0, 1)};
    triangle.triangles = {{0, 1, 2}};
    triangle.material = {0};
    triangle.original_face = {0};
    oblong = rectangle({-1, 0, 1}, {0, 1, 0}, {3, 0, 0});
    for (Mesh mesh : {triangle, oblong}) {
        add(mesh, rectangle({0, 0, 0}, {2, 0, 0}, {0, 2, 0}), 1);
        mesh.derive();
        const Discretised made(test::uniform_scene(mesh, 0.5, 0.0), 0.1, "cgal", "shepard");
        const Mesh& surface = made.scene.mesh;
        const Surfels& surfels = *made.discretisation.surfels;
        const AnalyticFactors factors(surface, surfels, static_cast<std::size_t>(even), Execution{});
        const SurfelGroups& groups = factors.tree().groups();
        const std::vector<std::vector<Index>> members = members_of(groups);
        AnalyticFactors::Worker worker;
        std::vector<AnalyticFactors::Factor> found;
        std::vector<Surfels::Piece> pieces;
        for (std::size_t j = 0; j < made.discretisation.points.size(); j += 23) {
            const SurfacePoint& x = made.discretisation.points[j];
            factors.find(x, found, worker);
            const Vec3 from = inset(surface, x).position;
            for (const auto& [group, factor, slope] : found) {
                double squares = 0.0; // of the kernel's deviation from linear, over the area
                for (const Index s : members[group]) {
                    const SurfacePoint y = surfels.centre(s, pieces);
                    const Vec3 way = y.position - from;
                    const double kernel = x.normal.dot(way) * -y.normal.dot(way) /
                                          (std::numbers::pi * way.squaredNorm() * way.squaredNorm()),
                                 linear = (factor + slope.dot(y.position - groups[group].centre)) / groups[group].area;
                    squares += surfels.area(s) * std::pow(kernel - linear, 2);
                }
                // A ΔK as a root mean square. At corners and between them it is at most sqrt(F / N) / 8, elsewhere 5/3
                // of that for quadratic functions (the Lebesgue constant of these points of a triangle).
                EXPECT_LE(std::sqrt(squares * groups[group].area), 5.0 / 3.0 * std::sqrt(factor / N) / 8.0);
            }
        }
    }
}

/// If light and kernel are greatest in the same places, errors of groups do not cancel: those of means alone would be
/// larger than what linear kernels are off by at most, sqrt(F / N) / 8 times the deviation of the light within a group.
TEST(AnalyticFactors, GroupsLoseNoLightThatLiesOpposite) {
    Mesh plates = rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    add(plates, rectangle({0, 0, 1}, {0, 1, 0}, {1, 0, 0}), 1);
    plates.derive();
    const Discretised made(test::uniform_scene(plates, 0.5, 0.0), 0.05, "cgal", "shepard");
    constexpr double even = 1024, N = even * 4;
    const AnalyticFactors factors(plates, *made.discretisation.surfels, static_cast<std::size_t>(even), Execution{});
    const Values b =
        light_on(made, [](const Vec3& y) { return std::exp(-4.0 * (y - Vec3(0.5, 0.5, y[2])).squaredNorm()); });
    const SurfelGroups& groups = factors.tree().groups();
    const Values moments = groups.moments_of(b), of_square = groups.moments_of(b.cwiseAbs2());
    AnalyticFactors::Worker worker;
    std::vector<AnalyticFactors::Factor> found;
    double sum = 0.0, by_means = 0.0, exact = 0.0, bound = 0.0;
    for (std::size_t j = 0; j < made.discretisation.points.size(); j += 7) {
        factors.find(made.discretisation.points[j], found, worker);
        for (const auto& [group, factor, slope] : found) {
            const Index at = SurfelGroups::mean_row(group);
            const double mean = moments(at, 0);
            by_means += factor * mean;
            bound += std::sqrt(factor / N) / 8.0 * std::sqrt(std::max(0.0, of_square(at, 0) - mean * mean));
        }
        sum += sum_of(factors, found, b);
        exact += surfel_by_surfel(made, made.discretisation.points[j], b);
    }
    EXPECT_NEAR(sum, exact, bound);
    EXPECT_LT(by_means, exact - bound);
}

TEST(SurfelGroups, MomentsAreThoseOfLinearLight) {
    const Discretised made(test::uniform_scene(spherical_cap(1.0, 0.7, 6, Front::inside), 0.5, 0.0), 0.1, "cgal",
                           "shepard");
    const AnalyticFactors factors(made.scene.mesh, *made.discretisation.surfels, 64, Execution{});
    const SurfelGroups& groups = factors.tree().groups();
    const Surfels& surfels = *made.discretisation.surfels;
    // The light y on surfels of which all is at the centroid: means are the centroids, and moments their covariances.
    std::vector<Vec3> centre(surfels.size(), Vec3::Zero());
    for (Index g = 0; g < groups.size(); ++g) {
        if (groups[g].second == none) {
            centre[groups[g].first] = groups[g].centre;
        }
    }
    Values b(static_cast<Eigen::Index>(surfels.size()), 4);
    for (Index s = 0; s < surfels.size(); ++s) {
        b.row(s) << 1.0, centre[s].transpose();
    }
    const Values moments = groups.moments_of(b);
    const std::vector<std::vector<Index>> members = members_of(groups);
    for (Index g = 0; g < groups.size(); ++g) {
        Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
        for (const Index s : members[g]) {
            const Vec3 way = centre[s] - groups[g].centre;
            covariance += surfels.area(s) / groups[g].area * way * way.transpose();
        }
        const Values own = moments.middleRows<SurfelGroups::moments>(SurfelGroups::mean_row(g));
        EXPECT_NEAR(own(0, 0), 1.0, 1e-12);
        EXPECT_NEAR(own.block(1, 0, 3, 1).norm(), 0.0, 1e-12);
        EXPECT_NEAR((own.block(0, 1, 1, 3).transpose() - groups[g].centre).norm(), 0.0, 1e-12);
        EXPECT_NEAR((own.block(1, 1, 3, 3) - covariance).norm(), 0.0, 1e-12);
    }
}

} // namespace
} // namespace difusa::surfel_groups_test
