// The factors of the transport operator against the operator itself.
#include <difusa/algebra/factors.h>
#include <difusa/core/random.h>
#include <difusa/radiosity/reflected_transport.h>

#include <meshes.h>
#include <support/discretised.h>
#include <support/plugins.h>

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

namespace difusa::factors_test {
namespace {

Eigen::MatrixXd dense_columns(const SparseColumns& columns, std::size_t rows, Eigen::Index channel) {
    Eigen::MatrixXd M =
        Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(columns.columns()));
    for (std::size_t i = 0; i < columns.columns(); ++i) {
        for (std::size_t e = columns.first[i]; e < columns.first[i + 1]; ++e) {
            M(columns.row[e], static_cast<Eigen::Index>(i)) += columns.value(static_cast<Eigen::Index>(e), channel);
        }
    }
    return M;
}

Eigen::MatrixXd dense_rows(const Factors& factors) {
    Eigen::MatrixXd M =
        Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(factors.A->rows()), static_cast<Eigen::Index>(factors.middle));
    const RowReader rows(*factors.A);
    std::vector<Index> columns;
    std::vector<double> weights;
    for (std::size_t j = 0; j < factors.A->rows(); ++j) {
        rows.row(j, columns, weights);
        for (std::size_t k = 0; k < columns.size(); ++k) {
            if (columns[k] < factors.middle) {
                M(static_cast<Eigen::Index>(j), columns[k]) += weights[k];
            }
        }
    }
    return M;
}

/// A closed box. W has columns of the sky all the same, which are not part of T.
struct Setting : test::Discretised {
    explicit Setting(const std::string& basis)
        : Discretised(test::uniform_scene(test::box(1.0, 1, true), 0.5, 1.0), 0.3, "cgal", basis) {}

    Values reflectances() const {
        RandomStream random(7, "reflectances");
        Values rho(static_cast<Eigen::Index>(discretisation.surfels->size()), 2);
        for (double& value : rho.reshaped()) {
            value = random.uniform();
        }
        return rho;
    }

    void correct() {
        ProjectionChoice choice;
        choice.kind = ProjectionKind::corrected;
        choice.in_equation = true;
        discretisation.projection = std::make_shared<Projection>(
            *discretisation.basis, sites(), choice, discretisation.points, discretisation.integrals, Execution{});
    }
};

void expect_factors(const Setting& setting, const LightTransport& transport) {
    const Values rho = setting.reflectances();
    const ReflectedTransport T(setting.discretisation, transport, rho);
    const std::shared_ptr<const Factors> factors = T.factors({});
    ASSERT_TRUE(factors);
    ASSERT_EQ(factors->size(), transport.points());
    const Values diagonal = factors->diagonal(Execution{2});
    const Eigen::MatrixXd A = dense_rows(*factors);
    EXPECT_EQ((dense_columns(factors->columns_of_A({}), A.rows(), 0) - A).cwiseAbs().maxCoeff(), 0.0);
    for (Eigen::Index c = 0; c < 2; ++c) {
        const Values own = rho.col(c);
        const Eigen::MatrixXd exact = test::dense(ReflectedTransport(setting.discretisation, transport, own));
        const Eigen::MatrixXd product = A * dense_columns(factors->Q, factors->middle, c);
        // Sums of at most a few hundred products, all below 1.
        EXPECT_LT((product - exact).cwiseAbs().maxCoeff(), 1e-13);
        EXPECT_LT((diagonal.col(c) - exact.diagonal()).cwiseAbs().maxCoeff(), 1e-13);
        // Power: what the surfels reflect of the light that the basis spreads over them.
        Values spread;
        const auto n = static_cast<Eigen::Index>(factors->size());
        setting.discretisation.averages->apply(setting.discretisation.projection->coefficients(Values::Identity(n, n)),
                                               spread, Execution{});
        double area = 0.0;
        Eigen::RowVectorXd power = Eigen::RowVectorXd::Zero(n);
        for (Eigen::Index s = 0; s < spread.rows(); ++s) {
            const double own_area = setting.discretisation.surfels->area(static_cast<Index>(s));
            power += own_area * rho(s, c) * spread.row(s);
            area += own_area;
        }
        EXPECT_LT((factors->power.col(c).transpose() - power).cwiseAbs().maxCoeff(), 1e-13 * area);
        EXPECT_DOUBLE_EQ(factors->area, area);
    }
}

TEST(Factors, AreThoseOfTheOperator) {
    for (const char* basis : {"normalized-radial", "shepard", "moving-least-squares"}) {
        SCOPED_TRACE(basis);
        Setting setting(basis);
        const LightTransport gathered = setting.gathered(64), paired = setting.paired("disc");
        expect_factors(setting, gathered);
        expect_factors(setting, paired);
        if (!setting.discretisation.basis->interpolates()) {
            setting.correct();
            ASSERT_TRUE(setting.discretisation.projection->matrix());
            expect_factors(setting, gathered);
            expect_factors(setting, paired);
        }
    }
}

TEST(Factors, DoNotExistWhereCoefficientsAreSolvedFor) {
    const Setting setting("radial:width=0.3");
    const LightTransport transport = setting.gathered(16);
    const Values rho = setting.reflectances();
    EXPECT_FALSE(ReflectedTransport(setting.discretisation, transport, rho).factors({}));
    EXPECT_FALSE(is_local({}, *setting.discretisation.basis));
    EXPECT_FALSE(setting.discretisation.projection->matrix());
    EXPECT_GT(setting.discretisation.projection->entry_count(), 0U);
}

} // namespace
} // namespace difusa::factors_test
