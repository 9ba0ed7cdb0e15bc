// Gathers by fresh rays that exact form factors correct.
#include <difusa/bake.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/radiosity/error_estimate.h>
#include <difusa/radiosity/exact_correction.h>
#include <difusa/rays/lambert.h>

#include <support/discretised.h>
#include <support/furnace.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numeric>
#include <vector>

namespace difusa::exact_correction_test {
namespace {

/// A tray of 3 by 2, a quarter high: from inside everything is in sight but the sky above the opening.
Mesh tray() {
    Mesh mesh = rectangle({0, 0, 0}, {3, 0, 0}, {0, 2, 0});
    const Vec3 up(0, 0, 0.25);
    add(mesh, rectangle({0, 0, 0}, {0, 2, 0}, up), 0);
    add(mesh, rectangle({3, 2, 0}, {0, -2, 0}, up), 0);
    add(mesh, rectangle({3, 0, 0}, {-3, 0, 0}, up), 0);
    add(mesh, rectangle({0, 2, 0}, {3, 0, 0}, up), 0);
    mesh.derive();
    return mesh;
}

/// A lit tray, by 64 rays from each point; its error is not estimated.
BakeResult baked_tray(const Scene& lit, double spacing, const char* analytic) {
    BakeOptions options;
    options.spacing = spacing;
    options.rays = 64;
    options.visibility = "cgal";
    options.analytic = analytic;
    options.error_points = 0;
    return test::baked(lit, options);
}

TEST(ExactCorrection, RowsAreThoseOfTheTransport) {
    const test::Discretised made(test::uniform_scene(tray(), 0.5, 0.0), 0.4, "cgal", "shepard");
    const Discretisation& discretisation = made.discretisation;
    const LightTransport by_rays = made.gathered(64);
    const LightTransport whole = with_analytic_factors(by_rays, made.scene.mesh, discretisation.points,
                                                       *discretisation.surfels, AnalyticUse::always, Execution{});
    for (const unsigned threads : {1U, 3U}) {
        const Execution execution{threads, nullptr, nullptr};
        const FactorsOfPoints factors(made.scene.mesh, discretisation.points, *discretisation.surfels, 64, execution);
        for (int time = 0; time < 2; ++time) {
            const LightTransport refined = factors.refine(by_rays, execution);
            EXPECT_EQ(test::dense_with_sky_summed(refined), test::dense_with_sky_summed(whole));
            EXPECT_EQ(refined.sky, whole.sky);
            EXPECT_EQ(refined.back, whole.back);
        }
    }
}

/// Of a constant light, and of a uniform sky, a point receives shares that the form factor of the opening tells.
TEST(ExactCorrection, ConstantLightIsExact) {
    constexpr double rho = 0.6, H = 0.75;
    Scene scene = test::uniform_scene(tray(), rho, 0.0);
    scene.sky = Rgb::Constant(2.0);
    const BakeResult result = baked_tray(scene, 0.2, "always");
    FieldParts parts = result.field().parts();
    ASSERT_NE(parts.sent, nullptr);
    parts.smooth.setConstant(H);
    const std::vector<SurfacePoint> x = even_points(result.scene->mesh, 300, RandomStream(1, "points"));
    const auto surfels = static_cast<Eigen::Index>(result.system->discretisation().surfels->size());
    const Field::SurfelMeans means{Values::Constant(surfels, parts.smooth.cols(), H),
                                   result.solution.light.first_bounce(), result.solution.light.even};
    parts.sent =
        std::make_shared<const Values>(light_sent(result.solution.light, means.smooth, false, true, parts.channels));
    const Field field(parts);
    const ExactCorrection correction(field.parts(), x, 1024, Execution{});
    const std::array<Vec3, 4> opening{Vec3(0, 0, 0.25), {0, 2, 0.25}, {3, 2, 0.25}, {3, 0, 0.25}};
    const Irradiance plain = field.gather_by_surfels(x, means, nullptr, 64, 7, "rays", Execution{}),
                     exact = field.gather_by_surfels(x, means, &correction, 64, 7, "rays", Execution{});
    EXPECT_EQ(exact.rays, plain.rays);
    double off = 0.0, noise = 0.0;
    for (std::size_t p = 0; p < x.size(); ++p) {
        const auto row = static_cast<Eigen::Index>(p);
        const double sky = lambert_form_factor(x[p].position, x[p].normal, opening);
        for (const Irradiance* const each : {&plain, &exact}) {
            double& largest = each == &plain ? noise : off;
            largest = std::max({largest, std::abs(each->direct(row, 0) - sky * 2.0),
                                std::abs(each->indirect(row, 0) - (1.0 - sky) * rho * H)});
        }
    }
    EXPECT_GT(noise, 1e-3);
    EXPECT_LT(off, 1e-9); // form factors of hundreds of groups, close to edges
    const PointValues gathered = field.at(x, 1024, 7, "rays", Execution{});
    EXPECT_LT(gathered.noise_of_irradiance.maxCoeff(), 1e-9);
    for (std::size_t p = 0; p < x.size(); ++p) {
        const double sky = lambert_form_factor(x[p].position, x[p].normal, opening);
        EXPECT_NEAR(gathered.H(static_cast<Eigen::Index>(p), 0), 2.0 * sky + rho * H * (1.0 - sky), 1e-9);
    }
}

/// Corrections take the noise of the rays that the estimate is made with, and no further rays.
TEST(ExactCorrection, TheEstimateCountsItsRaysOnce) {
    Scene scene = test::uniform_scene(tray(), 0.6, 0.0);
    scene.sky = Rgb::Constant(2.0);
    const BakeResult exact = baked_tray(scene, 0.3, "always"), plain = baked_tray(scene, 0.3, "never");
    const auto estimate = [](const BakeResult& result) {
        return estimate_error(result.solution, 210, 64, 1, FurtherRounds{0, 0.0}, Execution{});
    };
    const ErrorEstimate of_exact = estimate(exact), of_plain = estimate(plain);
    EXPECT_EQ(of_exact.rays_per_gather.front(), 64U);
    EXPECT_EQ(of_plain.rays_per_gather.front(), 64U);
    const auto noise = [](const ErrorEstimate& from) {
        return std::accumulate(from.spread.begin(), from.spread.end(), 0.0) / static_cast<double>(from.spread.size());
    };
    EXPECT_LT(noise(of_exact), 0.1 * noise(of_plain)); // as all but the light within surfels is exact
    EXPECT_EQ(of_exact.at.variance, of_exact.at.variance_of_fresh);
}

/// Whatever the light, the correction is 0 on average.
TEST(ExactCorrection, IsUnbiased) {
    Scene scene = test::uniform_scene(tray(), 0.6, 0.0);
    scene.suns = {{Vec3(1, 0.5, 1).normalized(), Rgb::Constant(3.0)}};
    const BakeResult result = baked_tray(scene, 0.3, "always");
    const FieldParts& parts = result.field().parts();
    ASSERT_NE(parts.sent, nullptr);
    const std::vector<SurfacePoint> x = even_points(result.scene->mesh, 40, RandomStream(2, "points"));
    // So many rays that groups are single surfels.
    const ExactCorrection correction(parts, x, 1'000'000'000, Execution{});
    constexpr int seeds = 60;
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(seeds);
    for (int seed = 0; seed < seeds; ++seed) {
        const LightTransport by_rays =
            gathered(result.system->tracer(), x, *result.system->discretisation().surfels,
                     result.system->fresh_directions(), 32, static_cast<std::uint64_t>(seed), Execution{});
        sum[seed] = correction.of(by_rays, Execution{}).indirect.mean();
    }
    const double mean = sum.mean(), deviation = std::sqrt((sum.array() - mean).square().sum() / (seeds - 1.0) / seeds);
    EXPECT_GT(deviation, 1e-5);
    EXPECT_LT(std::abs(mean), 5.3 * deviation); // one in a million, for Student's t of 59 degrees of freedom
}

} // namespace
} // namespace difusa::exact_correction_test
