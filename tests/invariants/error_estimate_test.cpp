#include <difusa/bake.h>
#include <difusa/import/shapes.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/radiosity/error_estimate.h>
#include <difusa/study/measure.h>

#include <support/plugins.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace difusa::error_estimate_test {
namespace {

Scene furnace(double rho, double E) {
    Scene scene;
    scene.mesh = box(Vec3::Zero(), Vec3::Ones(), 1, Front::inside);
    for (int face = 0; face < 6; ++face) {
        Material material;
        material.reflectance = Rgb::Constant(rho);
        material.emission = Rgb::Constant(E);
        scene.materials.push_back(material);
    }
    return scene;
}

BakeOptions coarse(double spacing, std::size_t rays) {
    BakeOptions options;
    options.spacing = spacing;
    options.rays = rays;
    options.visibility = "embree";
    if (test::registry().find("visibility", "embree") == nullptr) {
        options.visibility = "cgal";
    }
    return options;
}

BakeResult baked(Scene scene, const BakeOptions& options) {
    return bake(test::registry(), std::move(scene), "scene", options, Execution{});
}

TEST(ErrorEstimate, AnExactBakeHasNoResidual) {
    for (const char* const projection : {"natural", "corrected", "galerkin"}) {
        BakeOptions options = coarse(0.25, 64);
        options.projection = projection;
        options.solve.tolerance = 1e-12;
        const BakeResult result = baked(furnace(0.6, 2.0), options);
        const double B = 2.0 / 0.4;
        ASSERT_TRUE(result.error.has_value());
        EXPECT_NEAR(result.error->reflected, B - 2.0, 1e-9 * B);
        EXPECT_LT(result.error->high, 1e-9 * B);
        EXPECT_LT(result.error->bound_rms, 1e-8 * B);
        EXPECT_LT(result.residual.maxCoeff(), 1e-9 * B);
    }
}

/// In a closed furnace whose field is too bright by the constant d in irradiance the error is rho d everywhere, and the
/// residual rho rho d - rho d = -rho d (1 - rho): the bound is the error, exactly.
TEST(ErrorEstimate, TheBoundIsSharpForAConstantError) {
    for (const double rho : {0.2, 0.5, 0.95}) {
        BakeOptions options = coarse(0.25, 64);
        options.solve.tolerance = 1e-12;
        const BakeResult result = baked(furnace(rho, 1.0), options);
        FieldParts parts = result.field().parts();
        const double d = 0.03;
        parts.smooth.array() += d;
        const Field wrong(parts);
        const ErrorEstimate estimate = estimate_error(wrong, 100, 64, 1, Execution{});
        const double B = 1.0 / (1.0 - rho), residual = rho * d * (1.0 - rho);
        EXPECT_NEAR(estimate.rms, residual, 1e-9 * B);
        EXPECT_NEAR(estimate.low, residual, 1e-9 * B);
        EXPECT_NEAR(estimate.high, residual, 1e-9 * B);
        EXPECT_NEAR(estimate.largest, residual, 1e-9 * B);
        EXPECT_NEAR(estimate.bound_rms, rho * d, 1e-8 * B);
        EXPECT_NEAR(estimate.bound_largest, rho * d, 1e-8 * B);
        EXPECT_NEAR(estimate.reflected, B - 1.0 + rho * d, 1e-9 * B);
        const std::vector<SurfacePoint> x = even_points(result.scene->mesh, 50, RandomStream(2, "x"));
        const Values spread = spread_residual(estimate, *parts.system->discretisation().basis, x, Execution{});
        EXPECT_LT((spread.array() - residual).abs().maxCoeff(), 1e-6 * residual); // a root of differences of squares
    }
}

/// The noise of the rays does not count as residual: with 8 rays at a place or 512, the estimates agree within their
/// intervals, while the noise of 8 rays is several times as large.
TEST(ErrorEstimate, NoiseIsNotCountedAsError) {
    Scene scene = furnace(0.5, 0.0);
    scene.materials[4].emission = Rgb::Constant(1.0);
    const BakeResult result = baked(scene, coarse(0.2, 512));
    const ErrorEstimate few = estimate_error(result.field(), 4000, 8, 1, Execution{});
    const ErrorEstimate many = estimate_error(result.field(), 1000, 512, 2, Execution{});
    const std::vector<SurfacePoint> x = even_points(scene.mesh, 1000, RandomStream(3, "x"));
    const Irradiance a = result.field().gather(x, 8, 1, "one", Execution{}),
                     b = result.field().gather(x, 8, 1, "other", Execution{});
    const double noise = 0.5 * std::sqrt(0.5 * (a.direct + a.indirect - b.direct - b.indirect).squaredNorm() / 1000.0);
    EXPECT_GT(noise, 2.0 * few.high) << "else nothing is shown";
    EXPECT_LE(few.low, many.high);
    EXPECT_LE(many.low, few.high);
}

TEST(ErrorEstimate, ASurfaceThatAbsorbsNothingLeavesNoBound) {
    Scene scene = furnace(0.5, 1.0);
    scene.materials[0].reflectance = Rgb::Ones();
    scene.materials[0].emission = Rgb::Zero();
    const BakeResult result = baked(scene, coarse(0.25, 64));
    EXPECT_EQ(result.error->largest_reflectance, 1.0);
    EXPECT_TRUE(std::isinf(result.error->bound_rms));
}

TEST(ErrorEstimate, CanBeLeftOut) {
    BakeOptions options = coarse(0.25, 64);
    options.error_points = 0;
    const BakeResult result = baked(furnace(0.5, 1.0), options);
    EXPECT_FALSE(result.error.has_value());
    EXPECT_EQ(result.residual.size(), 0);
}

TEST(ErrorEstimate, HasTheSameBitsForAnyNumberOfThreads) {
    Scene scene = furnace(0.5, 0.0);
    scene.materials[4].emission = Rgb::Constant(1.0);
    BakeOptions options = coarse(0.25, 32);
    options.final_gather = 16;
    const BakeResult one = bake(test::registry(), scene, "scene", options, Execution{1, nullptr});
    const BakeResult three = bake(test::registry(), scene, "scene", options, Execution{3, nullptr});
    EXPECT_EQ(one.error->rms, three.error->rms);
    EXPECT_EQ(one.error->bound_rms, three.error->bound_rms);
    EXPECT_EQ(one.output.B, three.output.B);
    EXPECT_EQ(one.error_bound, three.error_bound);
}

/// On every scene with a known answer the true error is within the bound, whatever the method.
class Reference : public testing::TestWithParam<std::string> {};

TEST_P(Reference, ErrorsAreWithinTheirBounds) {
    MeasureOptions how;
    how.places = 500;
    const Judge judge(reference_case(GetParam()), how, Execution{2, nullptr});
    for (const auto& [basis, projection, final_gather] :
         std::vector<std::tuple<std::string, std::string, std::size_t>>{{"normalized-radial", "natural", 0},
                                                                        {"shepard", "natural", 64},
                                                                        {"moving-least-squares", "galerkin", 0}}) {
        BakeOptions options = coarse(judge.reference.spacings[0], 64);
        options.basis = basis;
        options.projection = projection;
        options.final_gather = final_gather;
        options.error_points = 200;
        const Measurement m = measure(test::registry(), judge, options, how, Execution{2, nullptr});
        ASSERT_FALSE(m.failed) << m.failure;
        // Beside the bound: what the facets or the finite size of the scene add, and the noise of a final gather at the
        // judged places, at most that of independent rays.
        const double noise =
            final_gather == 0 ? 0.0 : m.total.l2.reference / std::sqrt(static_cast<double>(final_gather));
        EXPECT_LE(m.total.l2.error, m.bound_rms + judge.reference.mesh_error * m.total.l2.reference + noise)
            << basis << ", " << projection;
        EXPECT_GT(m.total.l2.error, 0.0);
    }
}

INSTANTIATE_TEST_SUITE_P(All, Reference, testing::ValuesIn(reference_case_names()), [](const auto& which) {
    std::string name = which.param;
    name.erase(std::remove(name.begin(), name.end(), '-'), name.end());
    return name;
});

} // namespace
} // namespace difusa::error_estimate_test
