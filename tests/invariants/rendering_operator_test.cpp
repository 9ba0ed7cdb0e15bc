// The rendering operator against solutions of the equation, and its stated errors against those that it has.
#include <difusa/algebra/dense.h>
#include <difusa/core/error.h>
#include <difusa/radiosity/light_responses.h>
#include <difusa/radiosity/rendering_operator.h>
#include <difusa/radiosity/response.h>

#include <support/furnace.h>
#include <support/lightings.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace difusa::rendering_operator_test {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

class Rendering : public testing::Test {
  protected:
    Rendering() {
        BakeOptions options = lit::quick(0.6, 32);
        options.every_surface = true;
        Scene scene = test::bare_room();
        scene.sky = Rgb(0.5, 0.6, 0.7);
        scene.materials[1].reflectance = Rgb(0.8, 0.3, 0.1);
        scene.materials[3].reflectance = Rgb(0.2, 0.5, 0.1);
        const BakeResult result = lit::baked(scene, options);
        system = result.system;
        rho = result.solution.light.reflectance;
        radius = result.solution.spectral_radius;
        solve.tolerance = 1e-12;
    }

    Eigen::Index points() const { return static_cast<Eigen::Index>(system->transport().points()); }
    Eigen::Index surfels() const { return static_cast<Eigen::Index>(system->transport().surfels); }
    Values exact(const Values& g) const { return solve_for(*system, rho, g, solve, Execution{}); }
    RenderingOperator made(const std::string& choice, const Execution& execution = {}) const {
        return {system, rho, parse_operator(choice), radius, solve, execution};
    }

    /// (I - T)^-1 T^m D of the first channel in the norms of the area, column by column.
    Eigen::MatrixXd later_light(int bounces) const {
        const Values grey = rho.col(0);
        Values g;
        system->transport().gather(Values::Identity(surfels(), surfels()), {}, g, Execution{});
        Values h = solve_for(*system, grey, g, solve, Execution{});
        if (bounces > 0) {
            h -= g; // (I - T)^-1 T = (I - T)^-1 - I
        }
        const AreaNorms norms(system->discretisation());
        return norms.points().asDiagonal() * Eigen::MatrixXd(h) * norms.surfels().cwiseInverse().asDiagonal();
    }

    std::shared_ptr<const RadiositySystem> system;
    Values rho;
    double radius = 0.0;
    SolveOptions solve;
};

/// Both solve the same system, with a condition of some 10: rounding, and the tolerance of the solver.
TEST_F(Rendering, AsAMatrixIsTheSolution) {
    const RenderingOperator R = made("dense");
    const Values g = Values::Random(points(), 6);
    std::vector<double> stated;
    EXPECT_LE((R.apply(g, stated, Execution{}) - exact(g)).norm(), 1e-10 * g.norm());
    EXPECT_LE(stated.front(), 1e-12);
    EXPECT_GT(stated.front(), 0.0);
    EXPECT_EQ(R.bytes(), 3 * sizeof(double) * static_cast<std::size_t>(points() * points()));
}

/// What is left out of L has a norm between that of the best approximation (Eckart and Young) and the stated one; the
/// latter is at most (4 sqrt(2/pi) (sqrt(n) + 7))^(1/5) times it: a Gaussian vector of n entries is longer than
/// sqrt(n) + 7 with a probability below e^-24.
TEST_F(Rendering, OfLowRankLeavesOutNoMoreThanStated) {
    const AreaNorms norms(system->discretisation());
    for (const int bounces : {0, 1}) {
        const Eigen::MatrixXd L = later_light(bounces);
        const Eigen::VectorXd sigma = singular_values(L).sigma;
        for (const std::size_t rank : {4U, 24U}) {
            LowRankOptions options;
            options.rank = rank;
            options.bounces = bounces;
            options.solve = solve;
            const LowRankLight light = low_rank_light(*system, rho, options, Execution{}).front();
            const Eigen::MatrixXd near = norms.points().asDiagonal() * Eigen::MatrixXd(light.U * light.V.transpose()) *
                                         norms.surfels().cwiseInverse().asDiagonal();
            const double error = singular_values(L - near).sigma[0];
            EXPECT_GE(error, sigma[static_cast<Eigen::Index>(rank)] * (1.0 - 1e-9));
            EXPECT_GE(light.error, error * (1.0 - 1e-9));
            const double gauss = std::sqrt(static_cast<double>(surfels())) + 7.0;
            EXPECT_LE(light.error, std::pow(4.0 * std::sqrt(2.0 / lit::pi) * gauss, 0.2) * error);
            ASSERT_EQ(light.singular_values.size(), rank);
            for (std::size_t i = 0; i < rank; ++i) { // of a projection of L
                EXPECT_LE(light.singular_values[i], sigma[static_cast<Eigen::Index>(i)] * (1.0 + 1e-9));
            }
        }
    }
}

/// Also for right-hand sides that no light makes, and for lights.
TEST_F(Rendering, OfLowRankHasAtMostTheStatedErrors) {
    const AreaNorms norms(system->discretisation());
    Values g = Values::Random(points(), 6), lamp = Values::Zero(surfels(), 3);
    lamp.topRows(5).setOnes();
    system->transport().gather(lamp, {}, lamp, Execution{});
    g.rightCols(3) = lamp;
    const Values h = exact(g);
    for (const std::string choice :
         {"low-rank:rank=4,bounces=0", "low-rank:rank=24,bounces=1", "low-rank:rank=8,bounces=2"}) {
        std::vector<double> stated;
        const std::vector<double> error = norms.of_points(made(choice).apply(g, stated, Execution{}) - h);
        ASSERT_EQ(stated.size(), error.size());
        for (std::size_t c = 0; c < error.size(); ++c) {
            EXPECT_LE(error[c], stated[c]) << choice;
            EXPECT_GT(error[c], 1e-9 * stated[c]) << choice; // something is left out
        }
    }
}

/// With all directions nothing is left out but what the solver leaves.
TEST_F(Rendering, OfFullRankIsTheSolution) {
    const RenderingOperator R = made("low-rank:more=2,bounces=1,rank=" + std::to_string(points() - 2));
    Values g = Values::Random(points(), 3);
    system->transport().gather(Values::Random(surfels(), 3), {}, g, Execution{});
    const Values h = exact(g);
    std::vector<double> stated;
    const Values near = R.apply(g, stated, Execution{});
    EXPECT_LE((near - h).norm(), 0.05 * (h - g).norm()); // two of the least directions are missing
    const AreaNorms norms(system->discretisation());
    // What the solver leaves of these solutions, here and in the operator, is not part of what is stated.
    const double unsolved = 10.0 * solve.tolerance * norms.of_points(h).front();
    EXPECT_LE(norms.of_points(near - h).front(), stated.front() + unsolved);
}

TEST_F(Rendering, HasTheSameBitsForAnyNumberOfThreads) {
    const Execution one{1, nullptr, nullptr}, three{3, nullptr, nullptr};
    const Values g = Values::Random(points(), 3);
    for (const std::string choice : {"neumann:bounces=3", "dense", "low-rank:rank=10"}) {
        EXPECT_EQ(made(choice, one).apply(g, one), made(choice, three).apply(g, three)) << choice;
    }
}

/// Equal channels are one matrix, and the columns of all take part in one product.
TEST_F(Rendering, OfGreySurfacesIsStoredOnce) {
    const Values g = Values::Random(points(), 3), colours = rho;
    rho = colours.col(0).replicate(1, 3);
    const RenderingOperator three = made("low-rank:rank=10");
    EXPECT_EQ(three.bytes(), 2 * 10 * sizeof(double) * static_cast<std::size_t>(points()));
    rho = colours.leftCols(1);
    EXPECT_LE((three.apply(g, Execution{}) - made("low-rank:rank=10").apply(g, Execution{})).norm(), 1e-13 * g.norm());
}

/// In a furnace T multiplies by the reflectance, to rounding: the stated error is the error itself.
TEST_F(Rendering, HasTheStatedErrorsInAFurnace) {
    constexpr double half = 0.5;
    const BakeResult result = test::baked(test::furnace(half, 1.0), lit::quick(0.6, 32));
    system = result.system;
    rho = Values::Constant(surfels(), 1, half);
    radius = half;
    const Values g = Values::Constant(points(), 1, 2.0);
    for (const int bounces : {0, 1, 4, 20}) {
        std::vector<double> stated;
        const Values h = made("neumann:bounces=" + std::to_string(bounces)).apply(g, stated, Execution{});
        const double left = 4.0 * std::pow(half, bounces + 1); // of 2 / (1 - 1/2)
        EXPECT_NEAR(h.minCoeff(), 4.0 - left, 1e-12);
        EXPECT_NEAR(h.maxCoeff(), 4.0 - left, 1e-12);
        EXPECT_NEAR(stated.front(), left, 1e-12);
    }
    EXPECT_LE((made("dense").apply(g, Execution{}).array() - 4.0).abs().maxCoeff(), 1e-12);
}

/// Mixtures of solutions are solutions of mixtures, to the tolerance of both.
TEST_F(Rendering, OfChosenLightsIsThatOfTheirMixtures) {
    const Values g = Values::Random(points(), 4 * 3), factors = Values::Random(4, 3);
    const LightResponses lights(*system, rho, g, solve, Execution{});
    EXPECT_EQ(lights.lights(), 4U);
    Values mixed = Values::Zero(points(), 3), grey = mixed;
    for (Eigen::Index l = 0; l < 4; ++l) {
        mixed += g.middleCols(3 * l, 3) * factors.row(l).asDiagonal();
        grey += factors(l, 0) * g.middleCols(3 * l, 3);
    }
    EXPECT_LE((lights.mixed(factors, Execution{}) - exact(mixed)).norm(), 1e-9 * mixed.norm());
    EXPECT_LE((lights.mixed(factors.leftCols(1), Execution{}) - exact(grey)).norm(), 1e-9 * grey.norm());
}

TEST_F(Rendering, RefusesWhatItCannotBe) {
    EXPECT_THAT([&] { made("low-rank:rank=" + std::to_string(points())); },
                ThrowsMessage<UsageError>(HasSubstr("choose a lower rank, or dense")));
    EXPECT_THAT([] { parse_operator("low-rnk"); }, ThrowsMessage<UsageError>(HasSubstr("low-rank")));
    EXPECT_THROW(parse_operator("neumann:bounces=-1"), UsageError);
    EXPECT_THROW(parse_operator("dense:rank=3"), UsageError);
    radius = 1.0;
    EXPECT_THROW(made("neumann"), UsageError);
    EXPECT_EQ(parse_operator("low-rank:rank=8").text, "low-rank:rank=8,bounces=1,more=16");
}

} // namespace
} // namespace difusa::rendering_operator_test
