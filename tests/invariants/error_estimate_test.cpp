#include <difusa/bake.h>
#include <difusa/discretisation/facing_distance.h>
#include <difusa/import/shapes.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/radiosity/error_estimate.h>
#include <difusa/study/estimate_study.h>
#include <difusa/study/measure.h>
#include <difusa/transport/gathered.h>

#include <support/furnace.h>
#include <support/plugins.h>
#include <support/rooms.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numeric>
#include <tuple>

namespace difusa::error_estimate_test {
namespace {

using test::baked;
using test::furnace;

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

TEST(ErrorEstimate, AnExactBakeHasNoResidual) {
    for (const char* const projection : {"natural", "corrected", "galerkin"}) {
        BakeOptions options = coarse(0.25, 64);
        options.projection = projection;
        options.solve.tolerance = 1e-12;
        const BakeResult result = baked(furnace(0.6, 2.0), options);
        const double B = 2.0 / 0.4;
        ASSERT_TRUE(result.error.has_value());
        EXPECT_NEAR(result.error->reflected, B - 2.0, 1e-9 * B);
        EXPECT_LT(result.error->total.high, 1e-9 * B);
        EXPECT_LT(result.error->indirect.high, 1e-9 * B);
        EXPECT_LT(result.error->bound, 1e-8 * B);
        EXPECT_LT(result.errors->error.maxCoeff(), 1e-7 * B); // roots of rounding errors
    }
}

/// The solution with another field.
Solution with_field(const BakeResult& result, FieldParts parts) {
    Solution solution = result.solution;
    solution.field = std::make_shared<const Field>(std::move(parts));
    return solution;
}

/// In a closed furnace whose field is too bright by the constant d in irradiance the error is rho d everywhere, and the
/// residual rho rho d - rho d = -rho d (1 - rho): the bound is the error, exactly, and so is the estimate, up to the
/// noise of what is carried on.
TEST(ErrorEstimate, BoundAndEstimateAreSharpForAConstantError) {
    for (const double rho : {0.2, 0.5, 0.95}) {
        BakeOptions options = coarse(0.25, 64);
        options.solve.tolerance = 1e-12;
        const BakeResult result = baked(furnace(rho, 1.0), options);
        FieldParts parts = result.field().parts();
        const double d = 0.03;
        parts.smooth.array() += d;
        const ErrorEstimate estimate = estimate_error(with_field(result, parts), 400, 64, 1, {}, Execution{});
        const double B = 1.0 / (1.0 - rho), residual = rho * d * (1.0 - rho);
        EXPECT_NEAR(estimate.residual.rms, residual, 1e-9 * B);
        EXPECT_NEAR(estimate.residual.low, residual, 1e-6 * B); // the spread of equal values is a root of rounding
        EXPECT_NEAR(estimate.residual.high, residual, 1e-6 * B);
        EXPECT_NEAR(estimate.bound, rho * d, 1e-5 * B);
        EXPECT_NEAR(estimate.reflected, B - 1.0 + rho * d, 1e-9 * B);
        // The solve of what is carried is good to a tenth, and each group of points sums up to a constant.
        EXPECT_NEAR(estimate.total.rms, rho * d, 0.1 * rho * d) << rho;
        EXPECT_NEAR(estimate.carried.mean(), -d * rho, 0.1 * d * rho);
    }
}

/// A closed box, one wall of which emits; its error is not estimated.
BakeResult lit_from_one_side() {
    Scene scene = furnace(0.5, 0.0);
    scene.materials[4].emission = Rgb::Constant(1.0);
    BakeOptions options = coarse(0.2, 64);
    options.error_points = 0;
    return baked(scene, options);
}

/// Whatever stands for the light of a surfel, the correction at one of so many hits makes up for it: exactly where the
/// light is constant and so are the means, and otherwise on average.
TEST(ErrorEstimate, SurfelsStandForTheLightAtHitsWithoutBias) {
    const BakeResult result = lit_from_one_side();
    const Mesh& mesh = result.scene->mesh;
    std::vector<SurfacePoint> x;
    RandomStream stream(3, "points");
    for (int i = 0; i < 400; ++i) {
        const auto t = static_cast<Index>(stream.below(mesh.triangles.size()));
        x.push_back(uniform_point(mesh, t, stream.uniform(), stream.uniform()));
    }
    FieldParts constant = result.field().parts();
    constant.smooth.setConstant(0.75);
    const auto surfels = static_cast<Eigen::Index>(result.system->discretisation().surfels->size());
    const SurfelLight& light = result.solution.light;
    const auto difference = [&](const Field& field, const Values& smooth) {
        const Field::SurfelMeans means{smooth, light.first_bounce(), light.even};
        const Irradiance plain = field.gather_smooth(x, 100, 5, "rays", Execution{});
        const Irradiance fast = field.gather_by_surfels(x, means, nullptr, 100, 5, "rays", Execution{});
        EXPECT_EQ(fast.rays, plain.rays);
        EXPECT_EQ(fast.direct, plain.direct);
        return Values(fast.indirect - plain.indirect);
    };
    const Values same = Values::Constant(surfels, constant.smooth.cols(), 0.75);
    EXPECT_LT(difference(Field(constant), same).cwiseAbs().maxCoeff(), 1e-14);

    // Too bright by 1: a point has 6 or 7 of its 100 hits corrected by 16, and a mean of one half that is reflected.
    Values wrong;
    result.system->discretisation().averages->apply(result.field().parts().smooth, wrong, Execution{});
    wrong.array() += 1.0;
    const Eigen::VectorXd of = difference(result.field(), wrong).col(0);
    const auto n = static_cast<double>(of.size());
    const double mean = of.mean(), deviation = std::sqrt((of.array() - mean).square().sum() / (n - 1.0) / n);
    EXPECT_GT(deviation, 1e-4);                 // the means were wrong
    EXPECT_LT(std::abs(mean), 4.9 * deviation); // one in a million
}

/// With a limit, how often the error is measured, from the number of rays: each round has twice as many as the one
/// before.
TEST(ErrorEstimate, MeasuresAgainWhereThatMayReachTheLimit) {
    const BakeResult result = lit_from_one_side();
    const auto estimate = [&](const FurtherRounds& further) {
        return estimate_error(result.solution, 30, 8, 1, further, Execution{});
    };
    const ErrorEstimate once = estimate({0, 0.0});
    const auto rays = [&](double limit) { return estimate({1, limit / once.reflected}).rays / once.rays; };
    EXPECT_EQ(once.rays, 2 * once.points * once.rays_per_gather.front());
    const double middle = 0.5 * (once.total.rms + once.total.high);
    EXPECT_EQ(rays(1.01 * once.total.high), 1U); // below the limit already
    EXPECT_EQ(rays(0.99 * once.total.high), 3U);
    EXPECT_EQ(rays(1.01 * middle), 3U);
    EXPECT_EQ(rays(0.99 * middle), 1U); // too far above it
}

/// Where noise prevails, fewer points have more rays each; otherwise all points are measured, 140 of them beforehand.
TEST(ErrorEstimate, BalancesPointsAndRays) {
    const BakeResult result = lit_from_one_side();
    const auto estimate = [&](std::size_t rays, std::size_t rounds) {
        return estimate_error(result.solution, 1400, rays, 1, {rounds, 0.0}, Execution{});
    };
    const ErrorEstimate quiet = estimate(4096, 1);
    EXPECT_EQ(quiet.points, 1400U);
    EXPECT_EQ(quiet.rays, 2 * 4096 * (1400 + 140));
    const ErrorEstimate noisy = estimate(8, 1);
    EXPECT_LT(noisy.points, 700U);
    EXPECT_GE(noisy.rays / noisy.points, 2 * 2 * 8U);
    EXPECT_EQ(noisy.spread.size(), noisy.points);
    EXPECT_EQ(noisy.rays_per_gather.size(), noisy.points);
    EXPECT_EQ(noisy.at.size(), noisy.points);
    EXPECT_NEAR(std::accumulate(noisy.at.weight.begin(), noisy.at.weight.end(), 0.0), result.scene->mesh.area, 1e-9);
}

/// A floor in the penumbra of a black screen, and nothing else: all error is the noise of directly evaluated light. Its
/// mean square, found from two evaluations at many evenly spread points, lies between the ends of the estimate.
TEST(ErrorEstimate, KnowsTheNoiseOfDirectLight) {
    constexpr double rho = 0.5;
    Scene scene;
    Mesh& mesh = scene.mesh;
    mesh = test::together(rectangle({-2, -2, 0}, {4, 0, 0}, {0, 4, 0}), rectangle({-2, -2, 1}, {2, 0, 0}, {0, 4, 0}));
    mesh.material = {0, 0, 1, 1};
    mesh.derive();
    scene.materials.resize(2);
    scene.materials[0].reflectance = Rgb::Constant(rho);
    scene.materials[1].reflectance = Rgb::Zero();
    Sun sun{Vec3(0.3, 0.1, 1.0).normalized(), Rgb::Ones()};
    sun.disc = 0.2;
    scene.suns = {sun};
    const BakeResult result = baked(scene, coarse(0.25, 16));
    const Field& field = result.field();
    constexpr std::size_t count = 40'000;
    const std::vector<SurfacePoint> x = even_points(result.scene->mesh, count, RandomStream(1, "places"));
    DirectLight::Effort effort;
    const Values difference =
        field.sharp(x, 1, "one", Execution{}, effort) - field.sharp(x, 1, "other", Execution{}, effort);
    double sum = 0.0, squares = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
        const double noise = x[i].face < 2 ? 0.5 * std::pow(rho * difference(static_cast<Eigen::Index>(i), 0), 2) : 0.0;
        sum += noise;
        squares += noise * noise;
    }
    const double n = count, mean = sum / n, deviation = std::sqrt((squares / n - mean * mean) / n);
    ASSERT_LT(deviation, 0.1 * mean);
    const ErrorEstimate estimate = estimate_error(result.solution, 14000, 16, 1, {0, 0.0}, Execution{});
    EXPECT_LT(estimate.total.low * estimate.total.low, mean + 3.0 * deviation);
    EXPECT_GT(estimate.total.high * estimate.total.high, mean - 3.0 * deviation);
    EXPECT_LT(estimate.total.high, 1.5 * estimate.total.low); // or else the above says little
    EXPECT_LT(estimate.indirect.high, 1e-9);
}

/// Few points without noise leave doubt that more rays cannot remove: as many others join them.
TEST(ErrorEstimate, MeasuresAtOtherPointsWhereThatMayHelp) {
    const BakeResult result = lit_from_one_side();
    int joined = 0;
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        const auto estimate = [&](std::size_t rounds) {
            return estimate_error(result.solution, 28, 2048, seed, {rounds, 0.0}, Execution{});
        };
        const ErrorEstimate more = estimate(1);
        if (more.points == 28) {
            continue;
        }
        ++joined;
        EXPECT_EQ(more.points, 56U);
        EXPECT_EQ(more.at.size(), 56U);
        EXPECT_EQ(more.squared.size(), 56U);
        EXPECT_EQ(more.spread.size(), 56U);
        EXPECT_EQ(more.rays_per_gather.size(), 56U);
        EXPECT_NEAR(std::accumulate(more.at.weight.begin(), more.at.weight.end(), 0.0), result.scene->mesh.area, 1e-9);
        std::array<int, ErrorPoints::groups> of_group{};
        for (const Index g : more.at.group) {
            ++of_group[g];
        }
        EXPECT_EQ(*std::min_element(of_group.begin(), of_group.end()), 8);
        // Half of what counts is what was measured first.
        const ErrorEstimate once = estimate(0);
        EXPECT_EQ(more.squared.front(), once.squared.front());
        EXPECT_NEAR(more.at.weight.front(), 0.5 * once.at.weight.front(), 1e-12);
    }
    EXPECT_GT(joined, 0);
}

/// The light of emitters that the coefficients represent is the response to their emission.
TEST(ErrorEstimate, AResponseIsTheSolutionForTheseEmitters) {
    Scene scene = furnace(0.5, 0.0);
    scene.materials[4].emission = Rgb::Constant(1.0);
    BakeOptions options = coarse(0.2, 64);
    options.solve.tolerance = 1e-10;
    const BakeResult result = baked(scene, options);
    ASSERT_EQ(result.solution.area_lights, 0U);
    const SurfelLight& light = result.solution.light;
    const Values h = result.system->respond(light.reflectance, light.emission, options.solve, Execution{});
    // Both miss the solution by at most the tolerance over 1 - rho.
    EXPECT_LT((h - result.solution.h).cwiseAbs().maxCoeff(), 4e-10 * result.solution.h.maxCoeff());
}

TEST(ErrorEstimate, ItsPointsIntegrateAnythingThatIsReflected) {
    Scene scene = furnace(0.5, 0.0);
    scene.materials[4].emission = Rgb::Constant(1.0);
    scene.materials[2].reflectance = Rgb::Zero(); // no points there
    const BakeResult result = baked(scene, coarse(0.25, 64));
    const Surfels& surfels = *result.system->discretisation().surfels;
    const auto f = [](const SurfacePoint& x) { return std::exp(x.position.dot(Vec3(1.0, 2.0, -1.0))); };
    double exact = 0.0;
    for (Index t = 0; t < scene.mesh.triangles.size(); ++t) {
        for (int i = 0; i < 64 && scene.mesh.material[t] != 2; ++i) {
            for (int j = 0; j < 64; ++j) {
                exact += f(uniform_point(result.scene->mesh, t, (i + 0.5) / 64, (j + 0.5) / 64)) *
                         result.scene->mesh.areas[t] / 4096;
            }
        }
    }
    std::vector<double> sums;
    double largest = 0.0; // weight, over the mean
    double of_fewer = 0.0;
    for (std::uint64_t seed = 1; seed <= 64; ++seed) {
        const ErrorPoints points = ErrorPointSampler(result.solution, Execution{}).draw(1200, seed);
        ASSERT_EQ(points.size(), 1204U);
        double sum = 0.0, area = 0.0;
        RandomStream stream(seed, "fewer");
        const ErrorPoints fewer = fewer_points(points, 300, stream);
        ASSERT_EQ(fewer.size(), 301U);
        for (std::size_t p = 0; p < fewer.size(); ++p) {
            of_fewer += fewer.weight[p] * f(fewer.place[p]) / 64.0;
        }
        EXPECT_NEAR(std::accumulate(fewer.weight.begin(), fewer.weight.end(), 0.0), 5.0, 1e-12);
        for (std::size_t p = 0; p < points.size(); ++p) {
            const SurfacePoint& x = points.place[p];
            ASSERT_NE(scene.mesh.material[x.face], 2U);
            ASSERT_EQ(surfels.at(x.face, x.u, x.v), points.surfel[p]);
            ASSERT_GT(points.weight[p], 0.0);
            sum += points.weight[p] * f(x);
            area += points.weight[p];
            largest = std::max(largest, points.weight[p] * 1200.0 / 5.0);
        }
        EXPECT_NEAR(area, 5.0, 1e-12);
        sums.push_back(sum);
    }
    double mean = 0.0, squares = 0.0;
    for (const double sum : sums) {
        mean += sum / 64.0;
        squares += sum * sum / 64.0;
    }
    const double deviation = std::sqrt((squares - mean * mean) * 64.0 / 63.0); // of one of them
    EXPECT_LT(deviation, 0.05 * exact) << "else nothing is shown";
    // At most four parts of a mixture over distances that differ by a factor of 20. The bias of a ratio is at most its
    // deviation times the relative one of the sum that it is divided by (Hartley and Ross 1954), whose square is at
    // most that of weights between 0 and the largest.
    constexpr double most = 4.0 * 20.0;
    EXPECT_LT(largest, most);
    EXPECT_NEAR(mean, exact, (4.5 / 8.0 + std::sqrt(most / 1200.0)) * deviation);
    EXPECT_NEAR(of_fewer, exact, (4.5 / 8.0 + std::sqrt(most / 300.0)) * 2.0 * deviation);
}

/// Where light, variation and noise do not differ, points are as dense as what they face is near, and what each stands
/// for is in proportion to the distance.
TEST(ErrorEstimate, ItsPointsAreDenserBesideWhatTheyFace) {
    const BakeResult result = baked(furnace(0.5, 0.5), coarse(0.25, 64));
    const double spacing = 2.0 * result.system->discretisation().surfels->edge();
    const FacingDistance facing(result.scene->mesh);
    const ErrorPoints points = ErrorPointSampler(result.solution, Execution{}).draw(900, 1);
    std::array<double, ErrorPoints::groups> quotient{};
    int near = 0;
    for (std::size_t p = 0; p < points.size(); ++p) {
        const double distance = std::max(0.05 * spacing, facing(points.place[p], spacing));
        double& first = quotient[points.group[p]];
        first = first > 0.0 ? first : points.weight[p] / distance;
        EXPECT_NEAR(points.weight[p] / distance, first, 1e-9 * first);
        near += distance < 0.1 * spacing ? 1 : 0;
    }
    // Strips of 0.05 spacings along the edges are 4.9 % of the box: of evenly spread points, 44 ± 6.5 are there.
    EXPECT_GT(near, 100);
}

/// The noise of the rays does not count as residual: with 8 rays at a place or 512, the estimates agree within their
/// intervals, while the noise of 8 rays is several times as large.
TEST(ErrorEstimate, NoiseIsNotCountedAsError) {
    Scene scene = furnace(0.5, 0.0);
    scene.materials[4].emission = Rgb::Constant(1.0);
    const BakeResult result = baked(scene, coarse(0.2, 512));
    const ErrorEstimate few = estimate_error(result.solution, 4000, 8, 1, {0, 0.0}, Execution{});
    const ErrorEstimate many = estimate_error(result.solution, 1000, 512, 2, {0, 0.0}, Execution{});
    const std::vector<SurfacePoint> x = even_points(scene.mesh, 1000, RandomStream(3, "x"));
    const Irradiance a = result.field().gather(x, 8, 1, "one", Execution{}),
                     b = result.field().gather(x, 8, 1, "other", Execution{});
    const double noise = 0.5 * std::sqrt(0.5 * (a.direct + a.indirect - b.direct - b.indirect).squaredNorm() / 1000.0);
    EXPECT_GT(noise, 2.0 * few.residual.high) << "else nothing is shown";
    EXPECT_LE(few.residual.low, many.residual.high);
    EXPECT_LE(many.residual.low, few.residual.high);
    EXPECT_LE(few.total.low, many.total.high);
    EXPECT_LE(many.total.low, few.total.high);
}

TEST(ErrorEstimate, ASurfaceThatAbsorbsNothingLeavesNoBound) {
    Scene scene = furnace(0.5, 1.0);
    scene.materials[0].reflectance = Rgb::Ones();
    scene.materials[0].emission = Rgb::Zero();
    const BakeResult result = baked(scene, coarse(0.25, 64));
    EXPECT_EQ(result.error->largest_reflectance, 1.0);
    EXPECT_TRUE(std::isinf(result.error->bound));
}

TEST(ErrorEstimate, CanBeLeftOut) {
    BakeOptions options = coarse(0.25, 64);
    options.error_points = 0;
    const BakeResult result = baked(furnace(0.5, 1.0), options);
    EXPECT_FALSE(result.error.has_value());
    EXPECT_FALSE(result.errors.has_value());
}

TEST(ErrorEstimate, HasTheSameBitsForAnyNumberOfThreads) {
    Scene scene = furnace(0.5, 0.0);
    scene.materials[4].emission = Rgb::Constant(1.0);
    BakeOptions options = coarse(0.25, 32);
    options.final_gather = 16;
    const BakeResult one = bake(test::registry(), scene, "scene", options, Execution{1, nullptr});
    const BakeResult three = bake(test::registry(), scene, "scene", options, Execution{3, nullptr});
    EXPECT_EQ(one.error->total.rms, three.error->total.rms);
    EXPECT_EQ(one.error->indirect.high, three.error->indirect.high);
    EXPECT_EQ(one.error->bound, three.error->bound);
    EXPECT_EQ(one.output.B, three.output.B);
    EXPECT_EQ(one.errors->error, three.errors->error);
}

/// The noise that the map tells is that of the field: it is compared with the differences between the fields for other
/// rays at the same sites. The number of rays extrapolated from is a quarter of theirs, by a power of -1.5 where the
/// truth lies between -1 and -2: a factor of 2 in the mean square at most, and a quarter more for eight samples of
/// correlated noise; what bounces carry on of it adds less than (rho / (1 - rho))² times a share of low frequencies.
TEST(ErrorEstimate, TheMapsNoiseIsThatOfTheField) {
    Scene scene = furnace(0.3, 0.0);
    scene.materials[4].emission = Rgb::Constant(1.0);
    for (const char* const projection : {"natural", "corrected:in=equation", "galerkin"}) {
        BakeOptions options = coarse(0.2, 64);
        options.projection = projection;
        const BakeResult result = baked(scene, options);
        const Discretisation& discretisation = result.system->discretisation();
        const std::vector<SurfacePoint> x = even_points(result.scene->mesh, 500, RandomStream(3, "x"));
        const ErrorMap map(result.solution, *result.error, Execution{});
        const Values noise = map.at(x, Execution{}).noise;
        const Values own = result.field().evaluate_smooth(x, Execution{}).indirect;
        const Values direct = result.field().evaluate_smooth(x, Execution{}).direct;
        double squares = 0.0;
        for (int other = 0; other < 8; ++other) {
            SystemParts parts = result.system->parts();
            const Tracer tracer(parts.scene->mesh, *parts.engine);
            parts.transport = gathered(tracer, discretisation.points, *discretisation.surfels, *parts.directions,
                                       options.rays, 100 + static_cast<std::uint64_t>(other), Execution{});
            const auto system = std::make_shared<RadiositySystem>(std::move(parts));
            const Solution solution = system->solve(result.scene, {}, Execution{});
            const Irradiance there = solution.field->evaluate_smooth(x, Execution{});
            squares += 0.5 * 0.09 * (there.indirect + there.direct - own - direct).squaredNorm() / 8.0;
        }
        EXPECT_LT(squares, 2.5 * noise.squaredNorm()) << projection;
        EXPECT_GT(squares, noise.squaredNorm() / 2.5) << projection;
    }
}

/// With one element at each point, the error of the basis varies as the light does among neighbouring ones. The map's
/// mean square of the residual over the area is compared with that of what 4096 rays find, whose noise is below 1/64 of
/// the mean square of that of 64. What is told of the rest is measured at more than 200 points: the squares of a normal
/// distribution have twice their mean as variance, which allows for 0.3 in three standard deviations, and as much
/// again for where the map is looked at; of the noise, a factor of 2 as in the test above.
TEST(ErrorEstimate, TheMapKnowsTheErrorsOfPiecewiseConstantElements) {
    Scene scene = furnace(0.3, 0.0);
    scene.materials[4].emission = Rgb::Constant(1.0);
    for (const char* const basis : {"patch-constant", "patch-constant:display=gouraud"}) {
        BakeOptions options = coarse(0.1, 64);
        options.basis = basis;
        const BakeResult result = baked(scene, options);
        const std::vector<SurfacePoint> x = even_points(result.scene->mesh, 2000, RandomStream(3, "x"));
        const ErrorsAt errors = ErrorMap(result.solution, *result.error, Execution{}).at(x, Execution{});
        const double told = errors.discretisation.squaredNorm() + errors.noise.squaredNorm();
        const Irradiance truth = result.field().gather_smooth(x, 4096, 5, "truth", Execution{});
        const Irradiance own = result.field().evaluate_smooth(x, Execution{}, true);
        const double squares = 0.09 * (own.indirect + own.direct - truth.indirect - truth.direct).squaredNorm();
        EXPECT_LT(squares, 2.0 * told) << basis;
        EXPECT_GT(squares, told / 2.0) << basis;
    }
}

/// Beside black walls a floor that reflects receives no light from them, and none of their noise: what its error points
/// see tells nothing of the walls. The error that the map tells of the irradiance of these is compared with what many
/// more rays find. The floor is lit by a lamp alone, so that this light is exact up to the noise of the rays, and that
/// of 4096 has about (256 / 4096)^1.5 < 0.02 of the mean square of that of 256. The tolerance is that of the test
/// above for the noise; the rest of the error, of the basis, is in proportion to what is measured at 280 points.
TEST(ErrorEstimate, TheMapKnowsTheErrorsOnBlackWalls) {
    Scene scene = furnace(0.0, 0.0);
    scene.materials[4].reflectance = Rgb::Constant(0.3);
    PointLight lamp;
    lamp.position = Vec3(0.5, 0.4, 0.7);
    lamp.intensity = Rgb::Ones();
    scene.point_lights.push_back(lamp);
    for (const std::size_t rays : {std::size_t{64}, std::size_t{256}}) {
        const BakeResult result = baked(scene, coarse(0.2, rays));
        EXPECT_EQ(result.error->total.rms, 0.0); // of the radiosity, which is exact
        ASSERT_NE(result.error->of_irradiance, nullptr);
        const Mesh& mesh = result.scene->mesh;
        std::vector<SurfacePoint> x = even_points(mesh, 500, RandomStream(3, "x"));
        std::erase_if(x, [&](const SurfacePoint& p) { return mesh.material[p.face] == 4; });
        const ErrorsAt errors = ErrorMap(result.solution, *result.error, Execution{}).at(x, Execution{});
        EXPECT_EQ(errors.error.maxCoeff(), 0.0);
        const Values truth = result.field().gather_smooth(x, 4096, 5, "truth", Execution{}).indirect;
        const Values own = result.field().evaluate_smooth(x, Execution{}).indirect;
        EXPECT_LT((own - truth).squaredNorm(), 2.5 * errors.irradiance.squaredNorm()) << rays;
        EXPECT_GT((own - truth).squaredNorm(), errors.irradiance.squaredNorm() / 2.5) << rays;
    }
    // Where walls reflect a little, the points see their noise.
    for (Material& material : scene.materials) {
        material.reflectance = material.reflectance.max(0.01);
    }
    EXPECT_EQ(baked(scene, coarse(0.2, 64)).error->of_irradiance, nullptr);
}

/// A transport without rays has no noise of rays.
TEST(ErrorEstimate, PairwiseTransportHasNoNoise) {
    Scene scene = furnace(0.3, 0.0);
    scene.materials[4].emission = Rgb::Constant(1.0);
    BakeOptions options = coarse(0.25, 64);
    options.transport = "pairwise";
    const BakeResult result = baked(scene, options);
    EXPECT_EQ(result.errors->noise.maxCoeff(), 0.0);
    EXPECT_GT(result.errors->error.maxCoeff(), 0.0);
}

/// A grey scene is the same scene in three equal channels. The root mean square over the channels is that of one, up to
/// the difference of one part in 10^9 that keeps the channels apart. Where all surfaces reflect rho, the error of the
/// irradiance is that of the radiosity over rho.
TEST(ErrorEstimate, DoesNotDependOnTheNumberOfEqualChannels) {
    Scene scene = furnace(0.5, 0.0);
    scene.materials[4].emission = Rgb::Ones();
    for (const std::size_t final_gather : {0U, 16U}) {
        BakeOptions options = coarse(0.25, 64);
        options.final_gather = final_gather;
        const BakeResult grey = baked(scene, options);
        scene.materials[4].emission[2] = 1.0 + 1e-9;
        const BakeResult coloured = baked(scene, options);
        scene.materials[4].emission[2] = 1.0;
        ASSERT_EQ(grey.channels, 1);
        ASSERT_EQ(coloured.channels, 3);
        for (const auto member :
             {&ErrorsAt::noise, &ErrorsAt::discretisation, &ErrorsAt::error, &ErrorsAt::irradiance}) {
            const Values &one = *grey.errors.*member, &three = *coloured.errors.*member;
            EXPECT_GT(one.maxCoeff(), 0.0);
            EXPECT_LT((one - three).cwiseAbs().maxCoeff(), 1e-6 * one.maxCoeff()) << final_gather;
        }
        EXPECT_LT((grey.errors->error - 0.5 * grey.errors->irradiance).cwiseAbs().maxCoeff(),
                  1e-9 * grey.errors->error.maxCoeff());
    }
}

/// Channels are judged by themselves, and light groups change nothing.
TEST(ErrorEstimate, EachChannelCountsAndGroupsDoNot) {
    Scene scene = furnace(0.5, 1.0);
    for (Material& material : scene.materials) {
        material.reflectance = Rgb(0.2, 0.5, 0.9);
    }
    scene.materials[0].name = "one";
    BakeOptions options = coarse(0.25, 64);
    options.solve.tolerance = 1e-12;
    for (const bool groups : {false, true}) {
        options.light_groups = groups;
        const BakeResult result = baked(scene, options);
        FieldParts parts = result.field().parts();
        const Eigen::RowVector3d rho(0.2, 0.5, 0.9), d(0.03, -0.02, 0.01);
        parts.smooth.leftCols(3).rowwise() += d;
        const ErrorEstimate estimate = estimate_error(with_field(result, parts), 400, 64, 1, {}, Execution{});
        const double error = rho.cwiseProduct(d).norm();
        const double residual = rho.cwiseProduct(d).cwiseProduct(Eigen::RowVector3d::Ones() - rho).norm();
        EXPECT_NEAR(estimate.residual.rms, residual, 1e-8);
        EXPECT_NEAR(estimate.total.rms, error, 0.1 * error);
        for (Eigen::Index c = 0; c < 3; ++c) {
            EXPECT_NEAR(estimate.carried.col(c).mean(), -d[c] * rho[c], 0.1 * std::abs(d[c]) * rho[c]);
        }
    }
}

/// Of n bakes the upper end of the estimate may lie below the true error in 3 %: of 24, six or more do so with a
/// probability below 1e-4. What is drawn is fixed by the seeds; more bakes of more scenes: measure_accuracy --estimate.
TEST(ErrorEstimate, HoldsForManySeedsAndIsClose) {
    MeasureOptions how;
    how.places = 4000;
    const Judge judge(reference_case("manufactured-box"), how, Execution{2, nullptr});
    const KnownLight known = known_light(judge);
    BakeOptions options = coarse(0.25, 128);
    options.error_points = 400;
    const std::vector<EstimateTrial> trials =
        try_estimate(test::registry(), known, options, 24, Execution{2, nullptr}, [](const EstimateTrial&) {});
    int missed = 0;
    std::vector<double> ratio;
    for (const EstimateTrial& trial : trials) {
        missed += trial.total_estimate.high < trial.total ? 1 : 0;
        ratio.push_back(trial.total_estimate.high / trial.total);
        EXPECT_GT(trial.covered, 0.8);
    }
    EXPECT_LE(missed, 5);
    std::sort(ratio.begin(), ratio.end());
    EXPECT_LT(ratio[12], 2.0);
    EXPECT_LT(ratio.back(), 3.0);
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
        EXPECT_LE(m.total.l2.error, m.bound + judge.reference.mesh_error * m.total.l2.reference + noise)
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
