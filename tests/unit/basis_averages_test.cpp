#include <difusa/discretisation/basis_averages.h>
#include <difusa/mesh/surface_sampling.h>

#include <support/rooms.h>
#include <support/sited.h>

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace difusa::basis_averages_test {
namespace {

constexpr double unit = 0x1p-18; ///< of the weights

std::shared_ptr<Basis> bound_basis(const std::string& choice, const Mesh& mesh, const SiteSet& sites) {
    auto basis = test::plugin<Basis>(choice);
    basis->bind(mesh, sites);
    return basis;
}

TEST(BasisAverages, ConstantsComeThroughWithoutRounding) {
    for (const Mesh& mesh : {test::room_with_block(), test::box(1.0, 20), test::icosphere(3, 1e-5), test::l_room()}) {
        const double spacing = 0.08 * mesh.diameter();
        const SiteSet sites = test::poisson_sites(mesh, spacing);
        const Surfels surfels(mesh, 0.7 * spacing, Execution{});
        for (const std::string& name : test::plugin_names<Basis>()) {
            SCOPED_TRACE(name);
            const auto basis = bound_basis(name, mesh, sites);
            const BasisAverages P(*basis, surfels, Execution{});
            ASSERT_EQ(P.rows(), surfels.size());
            ASSERT_EQ(P.columns(), sites.size());
            EXPECT_GE(P.bytes(), 8 * P.rows());
            if (!basis->sums_to_one()) {
                continue;
            }
            Values means;
            // Sums of multiples of 2^-18 below 2^34: exact in any order.
            P.apply(Values::Ones(std::ssize(sites.points), 2), means, Execution{});
            EXPECT_EQ(means, Values::Ones(static_cast<Eigen::Index>(P.rows()), 2));
            for (Index s = 0; s < surfels.size(); ++s) {
                ASSERT_FALSE(P.is_empty(s));
            }
        }
    }
}

TEST(BasisAverages, TheTransposeIsTheTransposeAndThreadsDoNotMatter) {
    const Mesh mesh = test::room_with_block();
    const SiteSet sites = test::poisson_sites(mesh, 0.1);
    const Surfels surfels(mesh, 0.07, Execution{});
    for (const std::string& name : test::plugin_names<Basis>()) {
        const auto basis = bound_basis(name, mesh, sites);
        const BasisAverages P(*basis, surfels, Execution{}), P3(*basis, surfels, Execution{3});
        RandomStream random(1, "values");
        for (const Eigen::Index width : {1, 3, 6}) {
            Values x(std::ssize(sites.points), width), y(static_cast<Eigen::Index>(surfels.size()), width);
            for (Values* values : {&x, &y}) {
                for (double& value : values->reshaped()) {
                    value = random.uniform() - 0.5;
                }
            }
            Values Px, Pty, other;
            P.apply(x, Px, Execution{});
            P.apply_transpose(y, Pty, Execution{});
            // Sums of some ten thousand terms below 1.
            EXPECT_NEAR(y.cwiseProduct(Px).sum(), Pty.cwiseProduct(x).sum(), 1e-11) << name;
            P3.apply(x, other, Execution{3});
            EXPECT_EQ(Px, other);
            P3.apply_transpose(y, other, Execution{3});
            EXPECT_EQ(Pty, other);
        }
    }
}

/// Means of a linear function are its values at centroids, which moving least squares reproduce.
TEST(BasisAverages, OfMovingLeastSquaresKeepLinearFunctions) {
    const Mesh mesh = test::grid(1, 1);
    const SiteSet sites = test::poisson_sites(mesh, 0.05);
    const Surfels surfels(mesh, 0.033, Execution{});
    const auto basis = bound_basis("moving-least-squares", mesh, sites);
    const BasisAverages P(*basis, surfels, Execution{});
    const auto f = [](const Vec3& p) { return 0.3 + 0.9 * p.x() - 0.7 * p.y(); };
    Values c(std::ssize(sites.points), 1), means;
    for (std::size_t i = 0; i < sites.size(); ++i) {
        c(static_cast<Eigen::Index>(i), 0) = f(sites.points[i].position);
    }
    P.apply(c, means, Execution{});
    std::vector<Surfels::Piece> pieces;
    BasisRow row;
    for (Index s = 0; s < surfels.size(); ++s) {
        const SurfacePoint centre = surfels.centre(s, pieces);
        basis->evaluate(centre, row);
        // Each weight is rounded by half a unit, the largest by as much for each; |f| <= 1.2. And the basis itself.
        const double rounding = static_cast<double>(row.element.size()) * unit * 1.2;
        EXPECT_NEAR(means(static_cast<Eigen::Index>(s), 0), f(centre.position), rounding + 1e-10);
    }
}

/// One point for a surfel: the error of the midpoint rule, of second order in its size.
TEST(BasisAverages, ConvergeToTheMeansAtSecondOrder) {
    const Mesh mesh = test::grid(1, 1);
    const SiteSet sites = test::poisson_sites(mesh, 0.12);
    for (const std::string name : {"normalized-radial", "moving-least-squares"}) {
        const auto basis = bound_basis(name, mesh, sites);
        std::vector<double> error;
        for (const double edge : {0.08, 0.04, 0.02}) {
            const Surfels surfels(mesh, edge, Execution{});
            const BasisAverages P(*basis, surfels, Execution{});
            Values dense = Values::Identity(std::ssize(sites.points), std::ssize(sites.points)), averages;
            P.apply(dense, averages, Execution{});
            double squares = 0.0;
            std::vector<Surfels::Piece> pieces;
            BasisRow row;
            for (Index s = 0; s < surfels.size(); ++s) {
                surfels.pieces(s, pieces);
                Eigen::RowVectorXd difference = averages.row(static_cast<Eigen::Index>(s));
                // The means by a rule of second order on 64 triangles of the outline's fan.
                const ConvexPolygon& outline = pieces[0].outline;
                const double area = outline.area();
                for (std::size_t k = 2; k < outline.count; ++k) {
                    ConvexPolygon triangle;
                    for (const std::size_t corner : {std::size_t{0}, k - 1, k}) {
                        triangle.add(outline.corner[corner]);
                    }
                    constexpr int n = 4;
                    for (int i = 0; i < n; ++i) {
                        for (int j = 0; j < 2 * (n - i) - 1; ++j) {
                            const double third = j % 2 == 0 ? 1.0 / 3.0 : 2.0 / 3.0;
                            const double a = (i + third) / n, b = (j / 2 + third) / n; // NOLINT: pairs of triangles
                            const Eigen::Vector2d uv = triangle.corner[0] +
                                                       a * (triangle.corner[1] - triangle.corner[0]) +
                                                       b * (triangle.corner[2] - triangle.corner[0]);
                            basis->evaluate(mesh.at(pieces[0].triangle, uv.x(), uv.y()), row);
                            for (std::size_t e = 0; e < row.element.size(); ++e) {
                                difference[static_cast<Eigen::Index>(row.element[e])] -=
                                    triangle.area() / area / (n * n) * row.weight[e];
                            }
                        }
                    }
                }
                squares += surfels.area(s) * difference.squaredNorm();
            }
            error.push_back(std::sqrt(squares));
        }
        // The rule itself errs by 1/16 of what the midpoint does: 4 where both halve.
        EXPECT_GT(error[0] / error[1], 3.0) << name;
        EXPECT_GT(error[1] / error[2], 3.4) << name;
        EXPECT_LT(error[1] / error[2], 4.6) << name;
    }
}

} // namespace
} // namespace difusa::basis_averages_test
