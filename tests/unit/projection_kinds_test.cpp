#include <difusa/core/error.h>
#include <difusa/discretisation/discretisation.h>
#include <difusa/discretisation/projection.h>

#include <support/sited.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <meshes.h>

#include <algorithm>

namespace difusa::projection_kinds_test {
namespace {

const std::vector<std::string> kinds{
    "natural",       "interpolation",          "corrected",        "corrected:sweeps=3",
    "least-squares", "least-squares:points=2", "galerkin:points=4"};

/// Sites on a box, a basis on them, and the matrices of each projection as dense ones.
struct Setting {
    Mesh mesh = test::box(1.0, 2);
    SiteSet sites = test::poisson_sites(mesh, 0.25);
    std::shared_ptr<Basis> basis;
    std::vector<double> integrals;

    explicit Setting(const std::string& choice) : basis(test::plugin<Basis>(choice)) {
        basis->bind(mesh, sites);
        integrals = element_integrals(mesh, *basis, 0.25, Execution{});
    }

    Eigen::MatrixXd collocation(const std::vector<SurfacePoint>& points) const {
        Eigen::MatrixXd Z = Eigen::MatrixXd::Zero(std::ssize(points), static_cast<Eigen::Index>(basis->size()));
        BasisRow row;
        for (std::size_t q = 0; q < points.size(); ++q) {
            basis->evaluate(points[q], row);
            for (std::size_t k = 0; k < row.element.size(); ++k) {
                Z(static_cast<Eigen::Index>(q), static_cast<Eigen::Index>(row.element[k])) = row.weight[k];
            }
        }
        return Z;
    }
};

ProjectionChoice parsed(const std::string& choice) {
    std::string text;
    return parse_projection(choice, text);
}

/// P as a dense matrix, column by column.
Eigen::MatrixXd dense(const Projection& projection, std::size_t points) {
    const auto n = static_cast<Eigen::Index>(points);
    return projection.coefficients(Values(Eigen::MatrixXd::Identity(n, n)));
}

const std::vector<std::string> bases{"normalized-radial", "shepard", "moving-least-squares", "radial:width=0.3"};

TEST(ProjectionKinds, TheSitesComeFirstAmongThePoints) {
    const Setting setting("shepard");
    for (const std::string& kind : kinds) {
        const ProjectionChoice choice = parsed(kind);
        const std::vector<SurfacePoint> points = projection_points(choice, setting.mesh, setting.sites, 1);
        const bool more = choice.kind == ProjectionKind::least_squares || choice.kind == ProjectionKind::galerkin;
        const std::size_t n = setting.sites.size();
        EXPECT_EQ(points.size(),
                  more ? n + static_cast<std::size_t>((choice.points - 1.0) * static_cast<double>(n)) : n);
        for (std::size_t j = 0; j < n; ++j) {
            EXPECT_EQ(points[j].position, setting.sites.points[j].position);
        }
    }
}

/// What is in the space of the basis is found again: P Z = 1 wherever P inverts or minimises.
TEST(ProjectionKinds, FunctionsOfTheBasisAreReproduced) {
    for (const std::string& name : bases) {
        const Setting setting(name);
        for (const std::string& kind : kinds) {
            const ProjectionChoice choice = parsed(kind);
            if (choice.kind == ProjectionKind::natural || choice.kind == ProjectionKind::corrected) {
                continue;
            }
            SCOPED_TRACE(name + ", " + kind);
            const std::vector<SurfacePoint> points = projection_points(choice, setting.mesh, setting.sites, 1);
            const Projection projection(*setting.basis, setting.sites, choice, points, setting.integrals, Execution{});
            EXPECT_GE(projection.condition(), 1.0);
            const Eigen::MatrixXd PZ = dense(projection, points.size()) * setting.collocation(points);
            const auto n = PZ.rows();
            EXPECT_LT((PZ - Eigen::MatrixXd::Identity(n, n)).cwiseAbs().maxCoeff(), 1e-13 * projection.condition());
        }
    }
}

TEST(ProjectionKinds, ConstantsStayWhereElementsSumToOne) {
    for (const char* const name : {"normalized-radial", "shepard", "moving-least-squares"}) {
        const Setting setting(name);
        for (const std::string& kind : kinds) {
            SCOPED_TRACE(name + std::string(", ") + kind);
            const ProjectionChoice choice = parsed(kind);
            const std::vector<SurfacePoint> points = projection_points(choice, setting.mesh, setting.sites, 1);
            const Projection projection(*setting.basis, setting.sites, choice, points, setting.integrals, Execution{});
            const Values b = projection.coefficients(Values::Constant(std::ssize(points), 1, 3.0));
            EXPECT_LT((b.array() - 3.0).abs().maxCoeff(), 1e-13 * projection.condition());
        }
    }
}

TEST(ProjectionKinds, LeastSquaresLeaveAnOrthogonalResidual) {
    for (const std::string& name : bases) {
        const Setting setting(name);
        for (const bool weighted : {false, true}) {
            const ProjectionChoice choice = parsed(weighted ? "galerkin" : "least-squares");
            const std::vector<SurfacePoint> points = projection_points(choice, setting.mesh, setting.sites, 1);
            const Projection projection(*setting.basis, setting.sites, choice, points, setting.integrals, Execution{});
            const Eigen::MatrixXd Z = setting.collocation(points);
            // The weights as the projection sees them: P = M⁻¹ ZᵀW has M P = ZᵀW, and for a partition of unity the rows
            // of ZᵀW sum to W.
            const Eigen::MatrixXd residual =
                Eigen::MatrixXd::Identity(Z.rows(), Z.rows()) - Z * dense(projection, points.size());
            if (!weighted) {
                EXPECT_LT((Z.transpose() * residual).cwiseAbs().maxCoeff(), 1e-12 * projection.condition()) << name;
                continue;
            }
            // Weighted: the residual of any data is orthogonal in some inner product with positive weights that sum to
            // the surface, those of sites sharing their area with the points nearest to them. A naive twin of it:
            std::vector<std::size_t> owner(points.size()), members(setting.sites.size(), 0);
            for (std::size_t q = 0; q < points.size(); ++q) {
                double least = 1e300;
                for (std::size_t j = 0; j < setting.sites.size(); ++j) {
                    const double d = (points[q].position - setting.sites.points[j].position).squaredNorm();
                    if (d < least) {
                        least = d;
                        owner[q] = j;
                    }
                }
                ++members[owner[q]];
            }
            Eigen::VectorXd W(Z.rows());
            for (std::size_t q = 0; q < points.size(); ++q) {
                W[static_cast<Eigen::Index>(q)] = setting.integrals[owner[q]] / static_cast<double>(members[owner[q]]);
            }
            EXPECT_LT((Z.transpose() * W.asDiagonal() * residual).cwiseAbs().maxCoeff(),
                      1e-12 * projection.condition() * W.maxCoeff())
                << name;
        }
    }
}

TEST(ProjectionKinds, CorrectionIsThePolynomialOfTheCollocationMatrix) {
    for (const std::string& name : bases) {
        const Setting setting(name);
        const Eigen::MatrixXd Z = setting.collocation(setting.sites.points);
        const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(Z.rows(), Z.rows());
        for (const int sweeps : {1, 2, 3}) {
            const Projection projection(*setting.basis, setting.sites, {ProjectionKind::corrected, sweeps, false, 0.0},
                                        setting.sites.points, setting.integrals, Execution{});
            Eigen::MatrixXd sum = one, power = one;
            for (int k = 0; k < sweeps; ++k) {
                power = power * (one - Z);
                sum += power;
            }
            EXPECT_LT((dense(projection, setting.sites.size()) - sum).cwiseAbs().maxCoeff(), 1e-12) << name;
        }
    }
}

/// Values of 0 or more that are 0 on half of the box, coefficients of which each second one swings far beyond
/// them, and twice all those.
TEST(ProjectionKinds, LimitedCoefficientsKeepToTheValuesAround) {
    const Setting setting("normalized-radial");
    const Eigen::Index n = std::ssize(setting.sites.points);
    Values values(n, 2), wild(n, 2);
    RandomStream stream(1, "values");
    for (Eigen::Index j = 0; j < n; ++j) {
        const bool dark = setting.sites.points[static_cast<std::size_t>(j)].position.x() < 0.0;
        values(j, 0) = dark ? 0.0 : 1.0 + 0.1 * stream.uniform();
        wild(j, 0) = values(j, 0) + (j % 2 == 0 ? 1.0 : 0.01) * (4.0 * stream.uniform() - 2.0);
    }
    values.col(1) = 2.0 * values.col(0);
    wild.col(1) = 2.0 * wild.col(0);
    const Values kept = limited(*setting.basis, setting.sites, values, wild, Execution{});
    int moved = 0, stayed = 0;
    BasisRow row;
    for (Eigen::Index j = 0; j < n; ++j) {
        double least = values(j, 0), most = least;
        setting.basis->evaluate(setting.sites.points[static_cast<std::size_t>(j)], row);
        for (const Index i : row.element) {
            least = std::min(least, values(static_cast<Eigen::Index>(i), 0));
            most = std::max(most, values(static_cast<Eigen::Index>(i), 0));
        }
        const double low = std::max(0.0, least - 0.25 * (most - least)), high = most + 0.25 * (most - least);
        EXPECT_EQ(kept(j, 0), std::clamp(wild(j, 0), low, high));
        EXPECT_EQ(kept(j, 1), 2.0 * kept(j, 0)); // a doubling is exact
        (kept(j, 0) == wild(j, 0) ? stayed : moved)++;
    }
    EXPECT_GT(moved, 10);
    EXPECT_GT(stayed, 10);
}

TEST(ProjectionKinds, TransposedIsTheTransposedMap) {
    for (const std::string& name : bases) {
        const Setting setting(name);
        for (const std::string& kind : kinds) {
            SCOPED_TRACE(name + ", " + kind);
            const ProjectionChoice choice = parsed(kind);
            const std::vector<SurfacePoint> points = projection_points(choice, setting.mesh, setting.sites, 1);
            const Projection projection(*setting.basis, setting.sites, choice, points, setting.integrals, Execution{});
            RandomStream random(1, "values");
            Values x(static_cast<Eigen::Index>(setting.sites.size()), 2);
            for (double& value : x.reshaped()) {
                value = random.uniform() - 0.5;
            }
            const Values back = projection.transposed(x);
            ASSERT_EQ(back.rows(), std::ssize(points));
            const Eigen::MatrixXd P = dense(projection, points.size());
            // Two ways of the same solve, each backward stable.
            EXPECT_LT((back - P.transpose() * x).cwiseAbs().maxCoeff(),
                      1e-13 * projection.condition() * P.cwiseAbs().colwise().sum().maxCoeff());
        }
    }
}

/// What is limited as parts adds up to what is limited as a whole, and a part that is dark at a site stays dark there.
TEST(ProjectionKinds, LimitedPartsAddUpToTheLimitedSum) {
    const Setting setting("normalized-radial");
    const Eigen::Index n = std::ssize(setting.sites.points);
    Values values(n, 6), wild(n, 6);
    RandomStream stream(1, "values");
    for (Eigen::Index j = 0; j < n; ++j) {
        const Vec3& p = setting.sites.points[static_cast<std::size_t>(j)].position;
        for (Eigen::Index c = 0; c < 6; ++c) { // the second part, of columns 3 to 5, lights one half
            values(j, c) = c >= 3 && p.x() < 0.5 ? 0.0 : 1.0 + stream.uniform();
            wild(j, c) = values(j, c) * (3.0 * stream.uniform() - 0.5);
        }
    }
    const Values sum = sum_of_parts(values, 3), wild_sum = sum_of_parts(wild, 3);
    ASSERT_EQ(sum.cols(), 3);
    EXPECT_LE((sum - values.leftCols(3) - values.rightCols(3)).cwiseAbs().maxCoeff(), 0x1p-50);
    const Values kept = limited_parts(*setting.basis, setting.sites, values, wild, 3, Execution{});
    const Values whole = limited(*setting.basis, setting.sites, sum, wild_sum, Execution{});
    EXPECT_LE((sum_of_parts(kept, 3) - whole).cwiseAbs().maxCoeff(), 16 * 0x1p-53 * wild.cwiseAbs().maxCoeff());
    int dark = 0, moved = 0;
    for (Eigen::Index j = 0; j < n; ++j) {
        moved += kept.row(j) != wild.row(j) ? 1 : 0;
        if (values(j, 3) == 0.0) {
            EXPECT_EQ(kept.row(j).tail(3).norm(), 0.0);
            ++dark;
        }
    }
    EXPECT_GT(dark, 10);
    EXPECT_GT(moved, 10);
}

/// What is left open is chosen by the basis.
TEST(ProjectionKinds, QuasiInterpolantsAreCorrectedUnlessToldOtherwise) {
    for (const std::string& name : test::plugin_names<Basis>()) {
        SCOPED_TRACE(name);
        const auto basis = test::plugin<Basis>(name);
        const bool residual_to_put_back = basis->coefficients_are_values() && !basis->interpolates();
        std::string text;
        const ProjectionChoice choice = projection_for(*basis, "", text);
        EXPECT_EQ(choice.kind, residual_to_put_back ? ProjectionKind::corrected : ProjectionKind::natural);
        // What is sure to converge is solved as it is; without that certainty nothing is lost by correcting it, too.
        EXPECT_EQ(choice.in_equation, residual_to_put_back && !basis->partition_of_unity());
        EXPECT_EQ(projection_for(*basis, "galerkin", text).kind, ProjectionKind::galerkin);
        if (!residual_to_put_back) {
            EXPECT_THROW(projection_for(*basis, "corrected", text), UsageError);
        }
    }
}

TEST(ProjectionKinds, ChoicesAreReadAndRefused) {
    std::string text;
    EXPECT_EQ(parse_projection("corrected", text).kind, ProjectionKind::corrected);
    EXPECT_THAT(text, testing::HasSubstr("sweeps=2"));
    EXPECT_TRUE(parse_projection("corrected:in=equation", text).in_equation);
    EXPECT_THAT(text, testing::HasSubstr("in=equation"));
    EXPECT_EQ(parse_projection("least_squares:points=2.5", text).points, 2.5);
    for (const auto& [wrong, hint] :
         std::vector<std::pair<std::string, std::string>>{{"galerkn", "did you mean galerkin"},
                                                          {"corrected:sweep=2", "sweeps"},
                                                          {"corrected:in=both", "in"},
                                                          {"galerkin:points=0.5", "points"}}) {
        try {
            parse_projection(wrong, text);
            ADD_FAILURE() << wrong;
        } catch (const UsageError& error) {
            EXPECT_THAT(error.what(), testing::HasSubstr(hint));
        }
    }
}

} // namespace
} // namespace difusa::projection_kinds_test
