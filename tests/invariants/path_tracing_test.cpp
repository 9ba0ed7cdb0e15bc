// Bakes against plain path tracing, which has nothing in common with them but the rays.
#include "support/sanitized.h"

#include <difusa/bake.h>
#include <difusa/core/parallel.h>
#include <difusa/import/shapes.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/rays/lambert.h>
#include <difusa/study/path_tracer.h>
#include <difusa/study/split_square.h>

#include <support/sited.h>

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

namespace difusa::path_tracing_test {
namespace {

// Under the sanitizers few paths, so a wide margin, and a coarse bake.
const std::size_t paths = test::sanitized() ? 1024 : 65536;

/// The tracer itself: a floor under a lamp receives what Lambert says, and no more if all is black.
TEST(PathTracer, AgreesWithLambert) {
    Scene scene = test::uniform_scene(rectangle(Vec3::Zero(), Vec3(1, 0, 0), Vec3(0, 1, 0)), 0.0, 0.0);
    add(scene.mesh, rectangle(Vec3(0.2, 0.3, 0.8), Vec3(0, 0.5, 0), Vec3(0.4, 0, 0)), 1);
    scene.materials.resize(2);
    scene.materials[1].reflectance = Rgb::Zero();
    scene.materials[1].emission = Rgb(1, 2, 3);
    const auto visibility = test::plugin<Visibility>("cgal");
    visibility->build(scene.mesh);
    const SurfacePoint x = scene.mesh.at(0, 0.3, 0.3);
    const TracedLight traced = trace_paths(scene, *visibility, x, paths, RandomStream(1, "paths"));
    double exact = 0.0;
    for (const Index t : {2U, 3U}) {
        exact += lambert_form_factor(x.position, x.normal, scene.mesh.corner(t, 0), scene.mesh.corner(t, 1),
                                     scene.mesh.corner(t, 2));
    }
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(traced.mean[c], (c + 1) * exact, 4.5 * std::sqrt(traced.variance()[c]));
        EXPECT_GT(traced.variance()[c], 0.0);
    }
}

/// In a closed furnace of even emission and reflectance rho every path brings E (1 + rho + rho² ...) in the mean.
TEST(PathTracer, AgreesWithTheFurnace) {
    const Scene scene = test::uniform_scene(sphere(1.0, 2, Front::inside), 0.5, 1.0);
    const auto visibility = test::plugin<Visibility>("cgal");
    visibility->build(scene.mesh);
    const TracedLight traced =
        trace_paths(scene, *visibility, scene.mesh.at(7, 0.3, 0.3), paths, RandomStream(1, "paths"));
    EXPECT_NEAR(traced.mean[0], 2.0, 4.5 * std::sqrt(traced.variance()[0]));
    EXPECT_LT(std::sqrt(traced.variance()[0]), 0.2);
}

TEST(PathTracer, IsDarkWhereNothingEmits) {
    const Scene scene = test::uniform_scene(sphere(1.0, 1, Front::inside), 0.5, 0.0);
    const auto visibility = test::plugin<Visibility>("cgal");
    visibility->build(scene.mesh);
    const TracedLight traced = trace_paths(scene, *visibility, scene.mesh.at(0, 0.3, 0.3), 2, RandomStream(1, "paths"));
    EXPECT_TRUE((traced.mean == 0.0).all());
    EXPECT_TRUE((traced.variance() == 0.0).all());
}

/// The Cornell box as it is baked by default: within 0.5 % rms of the light that it reflects.
TEST(PathTracing, TheCornellBoxByDefault) {
    BakeOptions options;
    options.error_points = 0;
    if (test::sanitized()) {
        options.sites = 400;
        options.rays = 64;
    }
    options.output_spacing = 1.0;
    const Execution execution{2, nullptr};
    const BakeResult result =
        bake(test::registry(), std::filesystem::path(DIFUSA_TEST_DATA) / "cornell_box.obj", options, execution);
    const Scene& scene = *result.scene;
    // Few places with many paths each: for the same work that tells the mean of the squares best.
    const std::vector<SurfacePoint> x = even_points(scene.mesh, 64, RandomStream(11, "judged"));
    const PointValues values = result.field().at(x, 0, 1, "judged", execution);
    std::vector<std::array<TracedLight, 2>> traced(x.size());
    parallel_for(x.size(), 1, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t i = begin; i < end; ++i) {
            for (std::size_t half = 0; half < 2; ++half) {
                traced[i][half] = trace_paths(scene, *result.system->parts().engine, x[i], paths / 2,
                                              RandomStream(5, half == 0 ? "first" : "second", i));
            }
        }
    });
    SplitSquare square;
    double reflected = 0.0, noise = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        const Vec3 rho = values.rho.row(row).transpose(), sent = (values.B - values.E).row(row).transpose();
        std::array<Vec3, 2> off;
        std::array<Eigen::Matrix3d, 2> covariance;
        for (std::size_t half = 0; half < 2; ++half) {
            off[half] = sent - rho.cwiseProduct(traced[i][half].mean.matrix());
            covariance[half] = rho.asDiagonal() * traced[i][half].covariance * rho.asDiagonal();
            noise += 0.25 * covariance[half].trace();
        }
        square.add(off[0], covariance[0], off[1], covariance[1]);
        reflected += sent.squaredNorm();
    }
    RecordProperty("rms_error_percent", std::to_string(100.0 * std::sqrt(std::max(0.0, square.sum()) / reflected)));
    RecordProperty("standard_error_percent", std::to_string(100.0 * std::sqrt(noise / reflected)));
    const double limit = test::sanitized() ? 0.05 : 0.005;
    EXPECT_LT(square.sum() / reflected, limit * limit + 4.5 * square.deviation() / reflected)
        << "standard error of the paths: " << 100.0 * std::sqrt(noise / reflected) << " %";
}

} // namespace
} // namespace difusa::path_tracing_test
