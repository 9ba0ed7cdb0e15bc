#include <difusa/import/shapes.h>
#include <difusa/lighting/bright_surfels.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/rays/lambert.h>

#include <support/sited.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace difusa::bright_surfels_test {
namespace {

/// A floor 4 by 4 and a wall beside it, under a ceiling 2 above with a square hole, above which the sun is: it lights
/// one square metre of the floor. The reflectance is 1/2.
class SunThroughAHole : public testing::Test {
  protected:
    static constexpr double edge = 0.1;
    const Rgb sun{1, 2, 3};
    Scene scene;
    std::shared_ptr<Visibility> visibility;
    std::shared_ptr<Directions> directions = test::plugin<Directions>("low-discrepancy");
    std::shared_ptr<const DirectLight> light;
    std::unique_ptr<Surfels> surfels;
    SurfelLight on_surfels;
    Values first_bounce;
    std::unique_ptr<BrightSurfels> bounce;

    void SetUp() override {
        Mesh& mesh = scene.mesh;
        mesh = rectangle(Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 4, 0));
        add(mesh, rectangle(Vec3(0, 0, 0), Vec3(0, 0, 2), Vec3(4, 0, 0)), 0); // the wall y = 0
        const auto ceiling = [&](double x0, double x1, double y0, double y1) {
            add(mesh, rectangle(Vec3(x0, y0, 2), Vec3(0, y1 - y0, 0), Vec3(x1 - x0, 0, 0)), 0);
        };
        ceiling(0, 4, 0, 1.5);
        ceiling(0, 4, 2.5, 4);
        ceiling(0, 1.5, 1.5, 2.5);
        ceiling(2.5, 4, 1.5, 2.5);
        scene.materials.resize(1);
        scene.suns.push_back({Vec3::UnitZ(), sun});
        prepare();
    }

    void prepare() {
        visibility = test::plugin<Visibility>("cgal");
        visibility->build(scene.mesh);
        light = std::make_shared<DirectLight>(scene, tracer());
        surfels = std::make_unique<Surfels>(scene.mesh, edge, Execution{});
        on_surfels = light_on_surfels(scene, *surfels, *light, 3, 1, Execution{});
        first_bounce = on_surfels.first_bounce();
        bounce = std::make_unique<BrightSurfels>(scene, tracer(), *surfels, *light, on_surfels);
    }
    Tracer tracer() const { return {scene.mesh, *visibility}; }

    /// Places on the wall, a little above the floor at least.
    std::vector<SurfacePoint> on_wall(std::size_t count) const {
        RandomStream stream(5, "wall");
        std::vector<SurfacePoint> points;
        while (points.size() < count) {
            const double u = stream.uniform(), v = stream.uniform();
            points.push_back(uniform_point(scene.mesh, 2 + static_cast<Index>(points.size() % 2), u, v));
        }
        return points;
    }

    /// What the lit square sends to x, per unit of its radiosity.
    static double form_factor(const SurfacePoint& x) {
        const Vec3 a(1.5, 1.5, 0), b(2.5, 1.5, 0), c(2.5, 2.5, 0), d(1.5, 2.5, 0);
        return lambert_form_factor(x.position, x.normal, a, b, c) + lambert_form_factor(x.position, x.normal, a, c, d);
    }

    struct Estimates {
        Rgb exactly;    ///< fresh shadow rays, at what rays hit and at what is drawn
        Rgb on_surfels; ///< the light of the surfels that rays hit and of those that are drawn
        Rgb rays;       ///< fresh shadow rays at what rays hit alone
        Rgb shortened;  ///< as `exactly`, with `shortcut`
        Rgb emitted;    ///< of the emitter, at what rays hit and at what is drawn
    };
    Estimates estimate(const SurfacePoint& x, std::size_t number, const DirectionPool& pool,
                       const BrightSurfels::Shortcut* shortcut = nullptr) const {
        Hemisphere around(tracer(), pool);
        around.look(x, number);
        std::vector<SurfacePoint> met;
        std::vector<Index> bins;
        std::vector<double> weights;
        around.for_each(
            [&](const Hit& hit, double weight) {
                met.push_back(scene.mesh.at(hit.face, hit.u, hit.v));
                bins.push_back(surfels->at(hit.face, hit.u, hit.v));
                weights.push_back(weight);
            },
            [](const Vec3&, double) {});
        RandomStream stream(9, "bounce", number);
        BrightSurfels::Worker worker;
        Estimates result{Rgb::Zero(), Rgb::Zero(), Rgb::Zero(), Rgb::Zero(), Rgb::Zero()};
        bounce->gather_exactly(x, met, weights, pool.count(), stream, worker, {&result.exactly, 1},
                               {&result.emitted, 1});
        const Eigen::RowVectorXd H = bounce->gather(x, bins, weights, pool.count(), first_bounce, stream, worker);
        result.on_surfels = H.transpose().array();
        bounce->gather_exactly(x, met, weights, pool.count(), stream, worker, {&result.shortened, 1},
                               {&result.emitted, 1}, shortcut);
        std::vector<Rgb> sampled(met.size());
        light->sample(met, stream, sampled, worker.light);
        for (std::size_t p = 0; p < sampled.size(); ++p) {
            result.rays += weights[p] * scene.reflectance(met[p]) * sampled[p];
        }
        return result;
    }
};

/// All of the light comes from the square, whatever the surfels at its border are told to hold.
TEST_F(SunThroughAHole, TheBrightShareIsThatOfTheLitSquare) {
    const double area = scene.mesh.area;
    // Surfels fit into squares of side `edge`. Those that the border of 4 crosses count between not at all and wholly.
    const double border = 4.0 * std::sqrt(2.0) * edge;
    EXPECT_NEAR(bounce->bright_share(), 1.0 / area, border / area);
    EXPECT_EQ(bounce->places(100), 50U);
    EXPECT_GT(on_surfels.segments, 0U);
}

TEST_F(SunThroughAHole, RaysAndPlacesTogetherBringWhatLambertSays) {
    constexpr std::size_t N = 1024;
    const DirectionPool pool(*directions, N, 3);
    double both = 0.0, rays = 0.0, bound = 0.0, surfels_too = 0.0, shortened = 0.0;
    const BrightSurfels::Shortcut shortcut{first_bounce, on_surfels.even, 8};
    const std::vector<SurfacePoint> points = on_wall(400);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double exact = 0.5 * form_factor(points[i]);
        const Estimates got = estimate(points[i], i, pool, &shortcut);
        // Each of the samples, the radiosity over N or less, is between 0 and 1/2 over N, and together they come to
        // `exact` in the mean: independent ones have the variance exact/(2N) at most, stratified ones less.
        const double sigma = std::sqrt(0.5 * exact / double(N));
        EXPECT_NEAR(got.exactly[0], exact, 4.5 * sigma);
        EXPECT_NEAR(got.exactly[2], 3.0 * got.exactly[0], 4.0 * double(N) * 0x1p-53);
        both += std::pow(got.exactly[0] - exact, 2);
        surfels_too += std::pow(got.on_surfels[0] - exact, 2);
        shortened += std::pow(got.shortened[0] - exact, 2);
        rays += std::pow(got.rays[0] - exact, 2);
        bound += sigma * sigma;
    }
    EXPECT_LT(both, 0.1 * bound);
    EXPECT_LT(surfels_too, 0.1 * bound);
    EXPECT_LT(shortened, 0.1 * bound);
    EXPECT_LT(both, 0.2 * rays); // five times the rays and more for the same error, with half as many places
}

/// The same square, not lit but emitting, as part of a display that is dark elsewhere.
TEST_F(SunThroughAHole, BrightPartsOfEmittersAreSampledLikewise) {
    EXPECT_FALSE(bounce->samples_emission());
    EXPECT_EQ(on_surfels.uneven_emission.rows(), 0);
    scene.suns.clear();
    scene.materials[0].emission = Rgb(1, 2, 3);
    scene.materials[0].emission_pattern = [](const Vec3& p) {
        return p.z() == 0.0 && std::max(std::abs(p.x() - 2.0), std::abs(p.y() - 2.0)) < 0.5 ? 1.0 : 0.0;
    };
    prepare();
    ASSERT_TRUE(bounce->samples_emission());
    EXPECT_EQ(on_surfels.uneven_emission, on_surfels.emission);
    first_bounce = on_surfels.uneven_emission; // what stands for the light of the surfels
    constexpr std::size_t N = 1024;
    const DirectionPool pool(*directions, N, 3);
    double both = 0.0, surfels_too = 0.0, bound = 0.0;
    const std::vector<SurfacePoint> points = on_wall(400);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double exact = form_factor(points[i]);
        const Estimates got = estimate(points[i], i, pool);
        const double sigma = std::sqrt(exact / double(N)); // as above, of samples between 0 and 1/N
        EXPECT_NEAR(got.emitted[0], exact, 4.5 * sigma);
        EXPECT_NEAR(got.emitted[2], 3.0 * got.emitted[0], 4.0 * double(N) * 0x1p-53);
        EXPECT_TRUE((got.exactly == 0.0).all());
        both += std::pow(got.emitted[0] - exact, 2);
        surfels_too += std::pow(got.on_surfels[0] - exact, 2);
        bound += sigma * sigma;
    }
    EXPECT_LT(both, 0.1 * bound);
    EXPECT_LT(surfels_too, 0.1 * bound);
}

/// A mean over many points has next to no noise left, so that what the cells miss at the border would show; or that the
/// light of surfels is wrong, as here, if it were not corrected.
TEST_F(SunThroughAHole, NothingIsMissedOrCountedTwice) {
    constexpr std::size_t N = 16;
    const Values wrong = 0.5 * first_bounce + Values::Constant(first_bounce.rows(), 3, 0.05);
    const std::vector<std::uint8_t> all(surfels->size(), 1);
    const BrightSurfels::Shortcut shortcut{wrong, all, 4};
    const std::vector<SurfacePoint> points = on_wall(8000);
    const DirectionPool pool(*directions, N, 3);
    Eigen::Array2d sum = Eigen::Array2d::Zero(), variance = sum;
    double exact = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double expected = 0.5 * form_factor(points[i]);
        const Estimates got = estimate(points[i], i, pool, &shortcut);
        const Eigen::Array2d error = Eigen::Array2d(got.exactly[0], got.shortened[0]) - expected;
        sum += error;
        exact += expected;
        variance += error.square();
    }
    EXPECT_LT(std::abs(sum[0]), 4.0 * std::sqrt(variance[0]));
    EXPECT_LT(std::abs(sum[1]), 4.0 * std::sqrt(variance[1]));
    // Or the lines above say little: uncorrected, it would be off by about half of this.
    EXPECT_LT(std::sqrt(variance[0]), 0.005 * exact);
    EXPECT_LT(std::sqrt(variance[1]), 0.02 * exact);
}

/// Directions below the plane of the face are mirrored to above it, with rays and with places.
TEST_F(SunThroughAHole, AShadingNormalMeansTheSameToBoth) {
    constexpr std::size_t N = 1024, many = 16384;
    const DirectionPool few(*directions, N, 3), more(*directions, many, 4);
    std::vector<SurfacePoint> points = on_wall(20);
    for (std::size_t i = 0; i < points.size(); ++i) {
        points[i].normal = Vec3(0.3, 1.0, i % 2 == 0 ? -1.5 : 1.5).normalized();
        const double got = estimate(points[i], i, few).exactly[0], expected = estimate(points[i], i, more).rays[0];
        const double variance = 0.5 * expected * (1.0 / double(N) + 1.0 / double(many));
        EXPECT_NEAR(got, expected, 4.5 * std::sqrt(variance));
    }
}

/// A second wall hides the square from the first.
TEST_F(SunThroughAHole, PlacesThatAreHiddenDoNotCount) {
    SurfacePoint x = scene.mesh.at(2, 0.3, 0.3);
    add(scene.mesh, rectangle(Vec3(0, 0.5, 0), Vec3(4, 0, 0), Vec3(0, 0, 2)), 0);
    prepare();
    EXPECT_GT(bounce->places(64), 0U);
    const Estimates got = estimate(x, 0, DirectionPool(*directions, 64, 3));
    EXPECT_TRUE((got.exactly == 0.0).all());
    EXPECT_TRUE((got.on_surfels == 0.0).all());
}

/// Bright surfels of a scene without lamps.
struct Made {
    std::shared_ptr<Visibility> visibility = test::plugin<Visibility>("cgal");
    std::unique_ptr<DirectLight> light;
    std::unique_ptr<Surfels> surfels;
    SurfelLight on_surfels;
    std::unique_ptr<BrightSurfels> bright;

    explicit Made(const Scene& scene) {
        visibility->build(scene.mesh);
        const Tracer tracer(scene.mesh, *visibility);
        light = std::make_unique<DirectLight>(scene, tracer);
        surfels = std::make_unique<Surfels>(scene.mesh, 0.1, Execution{});
        on_surfels = light_on_surfels(scene, *surfels, *light, 3, 1, Execution{});
        bright = std::make_unique<BrightSurfels>(scene, tracer, *surfels, *light, on_surfels);
    }
};

TEST(BrightSurfels, WhereMostOfTheSurfaceIsBrightRaysServeAlone) {
    Scene scene;
    scene.mesh = rectangle(Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 2, 0));
    add(scene.mesh, rectangle(Vec3(0, 2, 0), Vec3(2, 0, 0), Vec3(0, 0, 2)), 0);
    scene.materials.resize(1);
    scene.suns.push_back({Vec3(0, -1, 1).normalized(), Rgb(1, 1, 1)});
    const Made made(scene);
    EXPECT_NEAR(made.bright->bright_share(), 1.0, 1e-12); // floor and wall are evenly lit
    EXPECT_EQ(made.bright->places(1024), 0U);
}

TEST(BrightSurfels, WithoutLightThereIsNothingToDo) {
    Scene scene;
    scene.mesh = rectangle(Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 2, 0));
    scene.materials.resize(1);
    const Made made(scene);
    EXPECT_EQ(made.bright->bright_share(), 0.0);
    EXPECT_EQ(made.bright->places(1024), 0U);
    EXPECT_EQ(made.on_surfels.segments, 0U);
}

} // namespace
} // namespace difusa::bright_surfels_test
