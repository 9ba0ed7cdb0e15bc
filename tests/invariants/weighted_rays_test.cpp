// Directions with weights: the sets of the lectures (hemicube, discretised sphere, Nusselt's disc) through the whole
// pipeline.
#include <difusa/bake.h>
#include <difusa/core/error.h>
#include <difusa/import/shapes.h>
#include <difusa/radiosity/error_estimate.h>
#include <difusa/radiosity/error_points.h>

#include <support/discretised.h>
#include <support/furnace.h>
#include <support/rooms.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace difusa::weighted_rays_test {
namespace {

using testing::HasSubstr;

std::vector<std::string> classical() {
    std::vector<std::string> all;
    for (const char* const name : {"hemicube", "sphere", "nusselt"}) {
        for (const char* const grid : {"random", "fixed"}) {
            all.push_back(std::string(name) + ":grid=" + grid);
        }
    }
    return all;
}

BakeOptions quick(const std::string& directions) {
    BakeOptions options;
    options.spacing = 0.25;
    options.rays = 108;
    options.visibility = "cgal";
    options.directions = directions;
    return options;
}

/// Weights are multiples of 2^-52 that sum to exactly 1: so do the rows of a closed room, in any order.
TEST(WeightedRays, RowsOfAClosedRoomSumToExactlyOne) {
    const test::Discretised room(test::uniform_scene(test::room_with_block(), 0.5, 1.0), 0.3, "cgal",
                                 "normalized-radial");
    for (const std::string& directions : classical()) {
        const LightTransport transport = room.gathered(300, directions);
        const Values sums = room.row_sums(transport);
        for (Eigen::Index j = 0; j < sums.rows(); ++j) {
            ASSERT_EQ(transport.sky[static_cast<std::size_t>(j)], 0.0);
            ASSERT_EQ(transport.back[static_cast<std::size_t>(j)], 0.0);
            if (directions.find("nusselt") == std::string::npos) {
                ASSERT_EQ(sums(j, 0), 1.0) << directions;
            } else {
                ASSERT_NEAR(sums(j, 0), 1.0, 1e-13); // a count times a rounded 1/N
            }
        }
    }
}

/// In a furnace every mean of the light is exact, so there is neither an error nor noise.
TEST(WeightedRays, AFurnaceIsExact) {
    for (const std::string& directions : classical()) {
        BakeOptions options = quick(directions);
        options.solve.tolerance = 1e-12;
        const BakeResult result = test::baked(test::furnace(0.6, 2.0), options);
        ASSERT_TRUE(result.error.has_value());
        EXPECT_LT(result.error->total.high, 1e-8) << directions;
        EXPECT_LT((result.solution.irradiance.array() - 5.0).abs().maxCoeff(), 1e-8) << directions;
    }
}

/// The variance of what the rays of a point meet counts each by its weight: by hand, from the rows of the transport.
/// That of a fixed set is no noise.
TEST(WeightedRays, HaveTheVarianceOfTheirWeights) {
    Scene scene = test::furnace(0.5, 0.0);
    scene.materials[4].emission = Rgb::Constant(1.0);
    for (const std::string& directions : classical()) {
        BakeOptions options = quick(directions);
        options.direct = "interpolated";
        const BakeResult result = test::baked(scene, options);
        const ErrorSources sources = error_sources(result.solution, Execution{});
        if (directions.find("fixed") != std::string::npos) {
            EXPECT_EQ(sources.variance.cwiseAbs().maxCoeff(), 0.0) << directions;
            continue;
        }
        const LightTransport& transport = result.system->transport();
        const SurfelLight& light = result.solution.light;
        const Values b = light.emission + light.reflectance.cwiseProduct(sources.light);
        const Values mean = test::Discretised::gather(transport, b);
        const Values square = test::Discretised::gather(transport, b.cwiseAbs2());
        EXPECT_LT((sources.variance - (square - mean.cwiseAbs2()).cwiseMax(0.0)).cwiseAbs().maxCoeff(), 1e-12);
        EXPECT_GT(sources.variance.mean(), 1e-3) << directions;
    }
}

/// The estimated share of noise is that of the rays: with a sixteenth of them it is larger.
TEST(WeightedRays, TheirNoiseIsToldFromTheErrorOfTheBasis) {
    Scene scene = test::furnace(0.5, 0.0);
    scene.materials[4].emission = Rgb::Constant(1.0);
    for (const char* const directions : {"hemicube", "sphere"}) {
        std::vector<double> noise;
        for (const std::size_t rays : {108U, 1728U}) {
            BakeOptions options = quick(directions);
            options.direct = "interpolated";
            options.rays = rays;
            options.error_points = 600;
            const BakeResult result = test::baked(scene, options);
            noise.push_back(result.errors->noise.squaredNorm() / static_cast<double>(result.errors->noise.rows()));
        }
        // The variance of stratified rays falls as their number to a power between 1 (independent) and 2 (smooth).
        const double order = std::log(noise[0] / noise[1]) / std::log(16.0);
        EXPECT_GT(order, 1.0) << directions;
        EXPECT_LT(order, 2.0) << directions;
    }
}

std::string refusal_of(const BakeOptions& options) {
    try {
        test::baked(test::furnace(0.5, 1.0), options);
    } catch (const UsageError& error) {
        return error.what();
    }
    return "";
}

TEST(WeightedRays, AnAccuracyIsNotOrderedFromRaysThatCannotTell) {
    BakeOptions options = quick("hemicube:grid=fixed");
    options.target = ErrorTarget{};
    options.spacing = 0.0; // both follow from the accuracy
    options.rays = BakeOptions{}.rays;
    EXPECT_THAT(refusal_of(options), HasSubstr("use a random grid"));
    options.directions = "hemicube:resolution=20";
    EXPECT_THAT(refusal_of(options), HasSubstr("omit its resolution"));
}

} // namespace
} // namespace difusa::weighted_rays_test
