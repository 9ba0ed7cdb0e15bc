#include <difusa/core/error.h>
#include <difusa/discretisation/evaluate.h>
#include <difusa/discretisation/projection.h>

#include <support/rooms.h>
#include <support/sited.h>

#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

namespace difusa::projection_test {
namespace {

Values random_values(std::size_t n, Eigen::Index channels) {
    RandomStream random(1, "values");
    Values y(static_cast<Eigen::Index>(n), channels);
    for (double& value : y.reshaped()) {
        value = random.uniform() - 0.3;
    }
    return y;
}

Eigen::MatrixXd collocation(const Basis& basis, const SiteSet& sites) {
    const auto n = static_cast<Eigen::Index>(sites.size());
    Eigen::MatrixXd Z = Eigen::MatrixXd::Zero(n, n);
    BasisRow row;
    for (Eigen::Index i = 0; i < n; ++i) {
        basis.evaluate(sites.points[static_cast<std::size_t>(i)], row);
        for (std::size_t k = 0; k < row.element.size(); ++k) {
            Z(i, static_cast<Eigen::Index>(row.element[k])) = row.weight[k];
        }
    }
    return Z;
}

TEST(Projection, ReproducesTheDataAtTheSitesWhereItSolves) {
    for (const Mesh& mesh :
         {test::box(1.0, 2), test::icosphere(2, 1e-6), test::l_room(), test::shelf_over_table(1e-7)}) {
        const SiteSet sites = test::poisson_sites(mesh, 0.07 * mesh.diameter());
        for (const std::string& name : test::plugin_names<Basis>()) {
            for (const std::string& choice :
                 name == "radial" ? std::vector<std::string>{"radial", "radial:profile=cubic", "radial:width=0.3"}
                                  : std::vector<std::string>{name}) {
                SCOPED_TRACE(choice);
                const auto basis = test::plugin<Basis>(choice);
                basis->bind(mesh, sites);
                const Projection projection(*basis, sites, Execution{});
                const Values y = random_values(sites.size(), 3), b = projection.coefficients(y);
                EXPECT_EQ(projection.is_identity(), basis->coefficients_are_values());
                if (projection.is_identity()) {
                    EXPECT_EQ(b, y);
                    EXPECT_EQ(projection.condition(), 1.0);
                    continue;
                }
                // LU leaves a residual of some n eps ‖Z‖ ‖b‖, and ‖b‖ <= cond ‖y‖ / ‖Z‖.
                const Values f = evaluate(*basis, b, sites.points, Execution{});
                EXPECT_LT((f - y).cwiseAbs().maxCoeff(), 1e-14 * projection.condition() * y.cwiseAbs().maxCoeff());
                EXPECT_LT((f - y).cwiseAbs().maxCoeff(), 1e-10);

                const Eigen::MatrixXd Z = collocation(*basis, sites);
                const auto norm_1 = [](const Eigen::MatrixXd& M) { return M.cwiseAbs().colwise().sum().maxCoeff(); };
                const double condition = norm_1(Z) * norm_1(Z.inverse());
                EXPECT_LE(projection.condition(), condition * (1.0 + 1e-6)) << "a lower bound";
                EXPECT_GE(projection.condition(), 0.1 * condition) << "Hager's estimate is seldom off by more";
            }
        }
    }
}

TEST(Projection, TransposedIntegratesTheInterpolant) {
    const Mesh mesh = test::box(1.0, 2);
    const SiteSet sites = test::poisson_sites(mesh, 0.15);
    for (const std::string& name : test::plugin_names<Basis>()) {
        const auto basis = test::plugin<Basis>(name);
        basis->bind(mesh, sites);
        const Projection projection(*basis, sites, Execution{});
        Values A(std::ssize(sites.points), 1);
        std::iota(A.data(), A.data() + A.size(), 1.0);
        const Values w = projection.transposed(A);
        const Values y = random_values(sites.size(), 1), b = projection.coefficients(y);
        const double by_weights = w.col(0).dot(y.col(0)), by_coefficients = A.col(0).dot(b.col(0));
        const double size = A.cwiseProduct(b).cwiseAbs().sum();
        EXPECT_NEAR(by_weights, by_coefficients, 1e-12 * projection.condition() * size) << name;
    }
}

TEST(Projection, RefusesElementsThatOverlapTooMuch) {
    const Mesh mesh = test::box(1.0);
    const SiteSet sites = test::poisson_sites(mesh, 0.06);
    const auto basis = test::plugin<Basis>("radial:width=3");
    basis->bind(mesh, sites);
    try {
        const Projection projection(*basis, sites, Execution{});
        ADD_FAILURE() << "condition " << projection.condition();
    } catch (const NotConverged& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr("condition"));
        EXPECT_THAT(error.what(), testing::HasSubstr("width"));
    }
}

} // namespace
} // namespace difusa::projection_test
