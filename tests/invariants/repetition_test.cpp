// Symmetry planes and periods: half a scene, or one period of it, bakes like the whole.
#include <difusa/bake/relight.h>
#include <difusa/core/random.h>
#include <difusa/lighting/direct_light.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/radiosity/moved_system.h>
#include <difusa/radiosity/sensors.h>
#include <difusa/rays/unfolded_visibility.h>
#include <difusa/scene/sky_dome.h>
#include <difusa/study/references/form_factors.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <support/discretised.h>
#include <support/lit_scenes.h>
#include <support/plugins.h>
#include <support/refusal.h>
#include <support/saved_bakes.h>
#include <support/unfolded.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

namespace difusa::repetition_invariants_test {
namespace {

using test::at_angle;
using test::plane;
using testing::HasSubstr;

constexpr double pi = std::numbers::pi;

/// The triangles of a mesh whose normal does not point that way.
Mesh without(const Mesh& mesh, const std::vector<Vec3>& normals) {
    Mesh rest;
    rest.points = mesh.points;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        if (std::none_of(normals.begin(), normals.end(),
                         [&](const Vec3& n) { return n.dot(mesh.normals[t]) > 0.99; })) {
            rest.triangles.push_back(mesh.triangles[t]);
            rest.material.push_back(mesh.material[t]);
            rest.original_face.push_back(static_cast<Index>(rest.original_face.size()));
        }
    }
    rest.derive();
    return rest;
}

/// All light that arrives directly.
std::vector<Rgb> direct_light(const Scene& scene, const std::vector<SurfacePoint>& points) {
    const auto engine = built_over(scene.mesh, test::plugin<Visibility>("cgal"));
    const DirectLight light(scene, Tracer(scene.mesh, *engine));
    DirectLight::Worker worker;
    std::vector<Rgb> result;
    for (const SurfacePoint& x : points) {
        RandomStream stream(1, "light");
        result.push_back(light.irradiance(x, 64, stream, worker));
    }
    return result;
}

PointLight lamp_at(const Vec3& position) {
    PointLight light;
    light.position = position;
    light.intensity = Rgb(3, 2, 1);
    return light;
}

// ---- direct light -----------------------------------------------------------------------------------------------

/// A floor sector of a wedge with a block and an emitting square, and lights: points where they shine and where not.
Scene wedge(const std::vector<Repetition::Plane>& planes) {
    Scene scene;
    scene.mesh.points = {Vec3(0, 0, 0), Vec3(3, 0, 0), Vec3(3, 3.0 * std::tan(pi / 5), 0)};
    scene.mesh.triangles = {{0, 1, 2}};
    scene.mesh.material = {0};
    scene.mesh.original_face = {0};
    scene.mesh.derive();
    add(scene.mesh, lit::plain_box(Vec3(1.2, 0.2, 0), Vec3(1.6, 0.5, 0.5), 1, Front::outside), 0);
    for (Index t = 0; t < scene.mesh.triangles.size(); ++t) {
        scene.mesh.original_face.resize(scene.mesh.triangles.size());
        scene.mesh.original_face[t] = t;
    }
    scene.mesh.repetition.planes = planes;
    settle_repetition(scene.mesh);
    scene.materials.resize(1);
    return scene;
}

/// Point lights, an extended one and suns in the planes: sharp light is the same to rounding.
TEST(Symmetry, LampsShineFromTheirImages) {
    const std::vector<std::vector<Repetition::Plane>> all{{plane({0, 1, 0})},
                                                          {plane({0, 1, 0}), plane({1, 0, 0})},
                                                          {plane({0, 1, 0}), plane(at_angle(pi / 3))},
                                                          {plane({0, 1, 0}), plane(at_angle(pi / 4))}};
    for (const auto& planes : all) {
        SCOPED_TRACE(planes.size());
        Scene cell = wedge(planes);
        cell.point_lights = {lamp_at(Vec3(0.9, 0.3, 1.0)), lamp_at(Vec3(2.0, 0.0, 0.7)), lamp_at(Vec3(0, 0, 1.4))};
        Scene whole = test::unfolded(cell);
        const LampImages images = LampImages::of(cell.mesh, 3);
        whole.point_lights.clear();
        for (const PointLight& light : cell.point_lights) {
            const auto same = with_images(light, images, cell.mesh);
            whole.point_lights.insert(whole.point_lights.end(), same.begin(), same.end());
        }
        const std::size_t order = images.images.size();
        // In general place: all images; in the first plane: half of them; at the edge of the wedge: one.
        EXPECT_EQ(whole.point_lights.size(), order + order / 2 + 1U);
        std::vector<SurfacePoint> points = even_points(cell.mesh, 300, RandomStream(2, "points"));
        const auto here = direct_light(cell, points), there = direct_light(whole, points);
        std::size_t shadowed = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            EXPECT_LT((here[i] - there[i]).abs().maxCoeff(), 1e-11 * (1.0 + there[i].maxCoeff())) << i;
            shadowed += there[i].maxCoeff() == 0.0 ? 1 : 0;
        }
        EXPECT_GT(shadowed, 5U);
    }
}

/// Where nothing blocks, the light of area lights is in closed form, and so is that of their images.
TEST(Symmetry, AreaLightsShineFromTheirImages) {
    for (const double angle : {pi / 2, pi / 3}) {
        Scene cell;
        cell.mesh = rectangle(Vec3(0.2, 0.05, 2), Vec3(0, 0.2, 0), Vec3(0.2, 0, 0));
        add(cell.mesh, rectangle(Vec3(3, 0, 0), Vec3(9, 0, 0), Vec3(0, 4, 0)), 1);
        cell.mesh.repetition.planes = {plane({0, 1, 0}), plane(at_angle(angle))};
        settle_repetition(cell.mesh);
        cell.materials.resize(2);
        cell.materials[0].emission = Rgb(5, 4, 3);
        const Scene whole = test::unfolded(cell);
        std::vector<SurfacePoint> points;
        for (const SurfacePoint& x : even_points(cell.mesh, 60, RandomStream(2, "points"))) {
            if (x.face > 1) {
                points.push_back(x);
            }
        }
        const auto here = direct_light(cell, points), there = direct_light(whole, points);
        for (std::size_t i = 0; i < points.size(); ++i) {
            EXPECT_GT(there[i][0], 0.0);
            EXPECT_LT((here[i] - there[i]).abs().maxCoeff(), 1e-12 * there[i].maxCoeff());
        }
    }
}

/// The sum of h / (r² + h²)^(3/2) over an endless row of lamps at the distance d from each other.
double row_of_lamps(double h, const std::function<double(int)>& along, double across, double d) {
    constexpr int n = 20000;
    double sum = 0.0;
    for (int k = -n; k <= n; ++k) {
        const double x = along(k);
        sum += h / std::pow(x * x + across * across + h * h, 1.5);
    }
    return sum + h / (d * d * d) / (static_cast<double>(n) * static_cast<double>(n)) * d; // the rest, as an integral
}

TEST(Symmetry, ParallelPlanesAndPeriodsMakeAnEndlessRowOfLamps) {
    constexpr double width = 2.0, h = 1.0;
    for (const bool periodic : {false, true}) {
        double last = 0.0;
        for (const std::size_t depth : {8U, 32U, 128U}) {
            Scene scene;
            scene.mesh = rectangle(Vec3(0, -1, 0), Vec3(width, 0, 0), Vec3(0, 2, 0));
            scene.mesh.mirrors.most = depth;
            if (periodic) {
                scene.mesh.repetition.periods = {Vec3(width, 0, 0)};
            } else {
                scene.mesh.repetition.planes = {plane({1, 0, 0}), plane({-1, 0, 0}, {width, 0, 0})};
            }
            settle_repetition(scene.mesh);
            scene.materials.resize(1);
            scene.point_lights = {lamp_at(Vec3(0.6, 0.3, h))};
            const double x = 1.5;
            const auto along = [&](int k) {
                const double place = k % 2 == 0 || periodic ? k * width + 0.6 : (k + 1) * width - 0.6;
                return place - x;
            };
            const double exact = row_of_lamps(h, along, 0.3, width);
            const double found = direct_light(scene, {{Vec3(x, 0, 0), Vec3::UnitZ(), 0, 0.5, 0.2}})[0][2];
            // What is left out: two ends, each at most the integral of h / x³ from (depth - 1) width on.
            const double end = static_cast<double>(depth - 1) * width;
            EXPECT_LT(found, exact);
            EXPECT_GT(found, exact - h / (width * end * end));
            EXPECT_GT(found, last);
            last = found;
        }
    }
}

TEST(Periodic, TheSunIsHiddenByTheBuildingOfTheNeighbour) {
    Scene scene;
    scene.mesh = rectangle(Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 10, 0));
    add(scene.mesh, lit::plain_box(Vec3(1, 1, 0), Vec3(3, 2, 3), 1, Front::outside), 0);
    scene.mesh.repetition.periods = {Vec3(0, 10, 0)};
    settle_repetition(scene.mesh);
    scene.materials.resize(1);
    Sun sun;
    sun.towards = Vec3(0, 4, 3).normalized(); // shadows are 4 long for 3 of height, towards -y
    sun.irradiance = Rgb::Ones();
    scene.suns = {sun};
    std::vector<SurfacePoint> ground;
    std::vector<double> expected;
    for (const double y : {0.25, 0.99, 2.01, 3.0, 6.99, 7.01, 9.5}) {
        for (const double x : {0.99, 1.01, 2.99, 3.01}) {
            ground.push_back({Vec3(x, y, 0), Vec3::UnitZ(), x / 4 < y / 10 ? 1U : 0U, 0.3, 0.3});
            // Of the building at y = 1 to 2: the ground from -3 to 1, which is 7 to 10 and 0 to 1 of the cell.
            const bool shadow = x > 1.0 && x < 3.0 && (y < 1.0 || y > 7.0);
            expected.push_back(shadow ? 0.0 : 0.6);
        }
    }
    const auto found = direct_light(scene, ground);
    for (std::size_t i = 0; i < ground.size(); ++i) {
        EXPECT_NEAR(found[i][0], expected[i], 1e-12) << ground[i].position.transpose();
    }
}

/// As bright on one side of the plane y = 0 as on the other, but of another colour.
struct RedAndBlueSky final : SkyDome {
    Rgb radiance(const Vec3& towards) const override { return towards.y() > 0.0 ? Rgb(1, 0, 0) : Rgb(0, 0, 1); }
    bool is_grey() const override { return false; }
};

TEST(Symmetry, LightThatIsNotSymmetricIsRefused) {
    Scene scene;
    scene.mesh = rectangle(Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 10, 0));
    scene.mesh.repetition.planes = {plane({0, 1, 0})};
    scene.materials.resize(1);
    const auto refusal = [&](const Scene& given) {
        return test::refusal_of([&] { lit::baked(given, lit::quick(1.0, 16)); }, "light");
    };
    Sun sun;
    sun.towards = Vec3(0, 0.6, 0.8);
    sun.irradiance = Rgb::Ones();
    scene.suns = {sun};
    EXPECT_THAT(refusal(scene), HasSubstr("towards (0, -0.6, 0.8)"));
    sun.towards.y() *= -1.0;
    scene.suns.push_back(sun);
    EXPECT_NO_THROW(lit::baked(scene, lit::quick(1.0, 16)));
    scene.suns[1].irradiance *= 2.0;
    EXPECT_THAT(refusal(scene), HasSubstr("symmetry plane 1"));
    scene.suns.clear();

    scene.point_lights = {lamp_at(Vec3(1, -1, 1))};
    EXPECT_THAT(refusal(scene), HasSubstr("1 m behind symmetry plane 1"));
    scene.point_lights[0].position.y() = 0.0;
    EXPECT_NO_THROW(lit::baked(scene, lit::quick(1.0, 16)));
    scene.point_lights[0].cos_outer = 0.5;
    scene.point_lights[0].cos_inner = 0.9;
    EXPECT_NO_THROW(lit::baked(scene, lit::quick(1.0, 16)));
    scene.point_lights[0].direction = Vec3(0, 0.6, -0.8);
    EXPECT_THAT(refusal(scene), HasSubstr("does not send the same light to both sides"));
    // A beam of a tenth of a degree, which hardly leaves the plane.
    scene.point_lights[0].direction = Vec3(0, 0.01, -1).normalized();
    scene.point_lights[0].cos_outer = scene.point_lights[0].cos_inner = std::cos(0.0017);
    EXPECT_THAT(refusal(scene), HasSubstr("does not send the same light to both sides"));
    scene.point_lights.clear();

    scene.dome = std::make_shared<GradientSky>(Rgb::Ones(), Rgb::Zero(), Rgb::Zero(), Vec3::UnitZ());
    EXPECT_NO_THROW(lit::baked(scene, lit::quick(1.0, 16)));
    scene.dome = std::make_shared<GradientSky>(Rgb::Ones(), Rgb::Zero(), Rgb::Zero(), Vec3(0, 0.6, 0.8));
    EXPECT_THAT(refusal(scene), HasSubstr("the sky is not symmetric"));
    scene.dome = std::make_shared<RedAndBlueSky>();
    EXPECT_THAT(refusal(scene), HasSubstr("the sky is not symmetric"));
}

// ---- transport --------------------------------------------------------------------------------------------------

/// A closed box with one or two walls replaced by planes, or two opposite ones by a period.
struct OpenBox {
    const char* name;
    std::vector<Vec3> open; ///< normals of the walls that are left out
    Repetition repetition;
};

std::vector<OpenBox> open_boxes() {
    const Vec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
    return {{"half", {x}, test::repeated({plane(x)}, {})},
            {"quarter", {x, y}, test::repeated({plane(x), plane(y)}, {})},
            {"eighth", {x, y, z}, test::repeated({plane(x), plane(y), plane(z)}, {})},
            {"parallel", {x, -x}, test::repeated({plane(x), plane(-x, x)}, {})},
            {"periodic", {x, -x}, test::repeated({}, {x})},
            {"lattice", {x, -x, y, -y}, test::repeated({}, {x, y})}};
}

/// Half a furnace, or one period of it, is as bright as the whole: every ray meets the surface.
TEST(Repetition, AFurnaceIsExactlyConstant) {
    constexpr double rho = 0.6, E = 2.0, B = E / (1.0 - rho);
    for (const OpenBox& of : open_boxes()) {
        SCOPED_TRACE(of.name);
        Scene scene =
            lit::scene_of(without(lit::plain_box(Vec3::Zero(), Vec3::Ones(), 1, Front::inside), of.open), rho);
        scene.materials[0].emission = Rgb::Constant(E);
        scene.mesh.repetition = of.repetition;
        BakeOptions options = lit::quick(0.3, 64);
        options.error_points = 32;
        const BakeResult result = lit::baked(scene, options);
        EXPECT_EQ(result.mean_cut_off, 0.0);
        EXPECT_LT((result.output.B.array() - B).abs().maxCoeff(), 1e-5 * B) << "to the tolerance of the solver";
        EXPECT_NEAR(result.solution.energy.imbalance[0], 0.0, 1e-5);
        EXPECT_LT(result.error->total.high, 1e-5);
        for (const double sky : result.system->transport().sky) {
            EXPECT_EQ(sky, 0.0);
        }
        // In mid-air, also in other cells. Upright: of the lattice floor and ceiling are left, and the horizon is dark.
        const std::vector<Sensor> sensors{{Vec3(0.3, 0.4, 0.5), Vec3(0.1, 0.2, 1).normalized(), SensorKind::planar},
                                          {Vec3(-0.4, 0.5, 0.5), -Vec3::UnitZ(), SensorKind::planar}};
        const SensorReadings readings = read_sensors(result.field(), sensors, 256, nullptr, 1, Execution{});
        EXPECT_LT((readings.H.array() - B).abs().maxCoeff(), 1e-5 * B);
    }
}

/// Below the sky, a street without end. At its middle the walls rise to the angle atan(2 h / w): the sky's share is the
/// cosine of that, w / sqrt(w² + 4 h²).
TEST(Periodic, TheSkyOverAStreetCanyonIsThatOfAnEndlessOne) {
    constexpr double w = 2.0, h = 1.5, length = 0.7;
    Scene scene = lit::scene_of(without(lit::plain_box(Vec3::Zero(), Vec3(w, length, h), 1, Front::inside),
                                        {Vec3(0, 1, 0), Vec3(0, -1, 0), Vec3(0, 0, -1)}),
                                0.5);
    scene.mesh.repetition.periods = {Vec3(0, length, 0)};
    settle_repetition(scene.mesh);
    const auto engine = built_over(scene.mesh, test::plugin<Visibility>("cgal"));
    const Surfels surfels(scene.mesh, 0.3, Execution{});
    std::vector<SurfacePoint> points;
    std::vector<double> expected;
    for (const SurfacePoint& x : even_points(scene.mesh, 200, RandomStream(4, "points"))) {
        points.push_back(x);
        const double p = x.position.x(), up = h - x.position.z();
        expected.push_back(x.normal.z() > 0.9 ? 0.5 * (p / std::hypot(p, h) + (w - p) / std::hypot(w - p, h))
                                              : 0.5 * (1.0 - up / std::hypot(up, w)));
    }
    constexpr std::size_t rays = 1024;
    const LightTransport transport = gathered({scene.mesh, *engine}, points, surfels,
                                              *test::plugin<Directions>("low-discrepancy"), rays, 1, Execution{});
    double mean = 0.0;
    for (std::size_t j = 0; j < points.size(); ++j) {
        // Five standard deviations of independent rays, which even ones stay well within.
        const double p = expected[j];
        EXPECT_NEAR(transport.sky[j], p, 5.0 * std::sqrt(p * (1.0 - p) / rays));
        mean += (transport.sky[j] - p) / static_cast<double>(points.size());
        EXPECT_EQ(transport.cut_off(static_cast<Eigen::Index>(j), 0), 0.0);
        EXPECT_NEAR(transport.back[j], 0.0, 1e-12);
    }
    EXPECT_LT(std::abs(mean), 5.0 * 0.5 / std::sqrt(static_cast<double>(rays * points.size())));
}

/// Between walls without end that emit and reflect, one above the other: form factors by crossed strings.
TEST(Periodic, AWallOfTheCanyonSeesTheOtherByCrossedStrings) {
    constexpr double w = 2.0, h = 1.5, length = 0.7;
    Mesh mesh = rectangle(Vec3(0, 0, 0), Vec3(0, length, 0), Vec3(0, 0, h)); // faces +x
    add(mesh, rectangle(Vec3(w, 0, 0), Vec3(0, 0, h), Vec3(0, length, 0)), 1);
    Scene scene;
    scene.mesh = mesh;
    scene.materials.resize(2);
    scene.materials[0].reflectance = Rgb::Zero();
    scene.materials[1].emission = Rgb::Ones();
    scene.materials[1].reflectance = Rgb::Zero();
    scene.mesh.repetition.periods = {Vec3(0, length, 0)};
    BakeOptions options = lit::quick(0.2, 512);
    const BakeResult result = lit::baked(scene, options);
    const double F = crossed_strings({0, 0}, {0, h}, {w, 0}, {w, h});
    double H = 0.0;
    std::vector<SurfacePoint> points;
    for (const SurfacePoint& x : even_points(scene.mesh, 1000, RandomStream(5, "points"))) {
        if (x.normal.x() > 0.0) {
            points.push_back(x);
        }
    }
    const PointValues light = result.field().at(points, 0, 1, "here", Execution{});
    H = light.H.col(0).mean();
    EXPECT_NEAR(H, F, 0.01 * F);
    // What is left out in the distance is cut off nowhere, and the rest goes to the sky.
    EXPECT_EQ(result.mean_cut_off, 0.0);
}

/// A room of two mirror-image halves with a lamp and a block in each, and the half.
Scene half_room() {
    Scene scene;
    scene.mesh = without(lit::plain_box(Vec3(0, 0, 0), Vec3(1, 1, 1), 1, Front::inside), {Vec3(1, 0, 0)});
    add(scene.mesh, lit::plain_box(Vec3(0.4, 0.4, 0), Vec3(0.6, 0.7, 0.5), 1, Front::outside), 0);
    add(scene.mesh, rectangle(Vec3(0.45, 0.2, 0.95), Vec3(0, 0.3, 0), Vec3(0.3, 0, 0)), 1);
    scene.mesh.original_face.resize(scene.mesh.triangles.size());
    for (Index t = 0; t < scene.mesh.triangles.size(); ++t) {
        scene.mesh.original_face[t] = t;
    }
    scene.mesh.repetition.planes = {plane({1, 0, 0})};
    settle_repetition(scene.mesh);
    scene.materials.resize(2);
    scene.materials[0].reflectance = Rgb(0.6, 0.5, 0.4);
    scene.materials[1].emission = Rgb::Constant(20.0);
    return scene;
}

TEST(Symmetry, HalfASceneIsTheWholeScene) {
    BakeOptions options;
    options.rays = 96;
    options.error_points = 128;
    options.sites = 600;
    const Scene cell = half_room();
    const BakeResult half = lit::baked(cell, options);
    options.sites = 1200;
    const BakeResult whole = lit::baked(test::unfolded(cell), options);
    const std::vector<SurfacePoint> points = even_points(cell.mesh, 500, RandomStream(3, "points"));
    // The first triangles of the whole are those of the half.
    const PointValues a = half.field().at(points, 0, 5, "here", Execution{});
    const PointValues b = whole.field().at(points, 0, 5, "here", Execution{});
    const double difference = std::sqrt((a.B - b.B).rowwise().squaredNorm().mean());
    // Each lies below with 97.5 %; the bakes share no random numbers that matter.
    EXPECT_LE(difference, half.error->total.high + whole.error->total.high);
    EXPECT_GT(difference, 0.0);
    // And in the mean, which is more accurate than each value.
    EXPECT_NEAR(a.B.mean(), b.B.mean(), 0.005 * b.B.mean());
}

TEST(Repetition, HasTheSameBitsForAnyNumberOfThreads) {
    Scene scene = half_room();
    scene.mesh.repetition.periods = {Vec3(0, 1.5, 0)};
    scene.point_lights = {lamp_at(Vec3(0.5, 0.2, 0.8))};
    scene.sky = Rgb::Ones();
    const auto with = [&](unsigned threads) {
        return bake(test::registry(), scene, "scene", lit::quick(0.25, 64), Execution{threads, nullptr, nullptr});
    };
    const BakeResult one = with(1), three = with(3);
    EXPECT_TRUE((one.solution.h.array() == three.solution.h.array()).all());
    EXPECT_TRUE((one.output.B.array() == three.output.B.array()).all());
}

TEST(Repetition, RelitResultsHaveTheBitsOfABake) {
    Scene scene = half_room();
    scene.mesh.repetition.periods = {Vec3(0, 1.5, 0)};
    const BakeOptions options = test::relightable("gather", "moving-least-squares");
    const SavedTransport saved = test::through_file(bake(test::registry(), scene, "scene", options, Execution{}));
    EXPECT_EQ(saved.gathered.cut_off.rows(), static_cast<Eigen::Index>(saved.gathered.points()));
    EXPECT_EQ(saved.options.sampler, "poisson-disk");
    scene.materials[0].reflectance = Rgb(0.2, 0.6, 0.8);
    test::expect_bits_of_a_bake(saved, scene, options);
    const RelightOptions again = test::as_baked(saved);
    // Planes and periods are geometry.
    const auto relit_with = [&](const Repetition& repetition) {
        Scene other = scene;
        other.mesh.repetition = repetition;
        return relight(test::registry(), saved, other, "scene", again, Execution{});
    };
    EXPECT_THROW(relit_with({}), InputError);
    EXPECT_THROW(relit_with(test::repeated({plane({1, 0, 0})}, {Vec3(0, 1.25, 0)})), InputError);
    EXPECT_THROW(relit_with(test::repeated({plane({1, 0, 0}, {-0.1, 0, 0})}, {Vec3(0, 1.5, 0)})), InputError);
    EXPECT_NO_THROW(relit_with(test::repeated({plane({1, 0, 0}, {0, 7, 3})}, {Vec3(0, 1.5, 0)})))
        << "another point of the plane";
}

TEST(Repetition, ASavedTransportKnowsWhatStopsTheSolver) {
    BakeOptions options = test::relightable("gather", "");
    options.stop = "change";
    const SavedTransport saved = test::through_file(bake(test::registry(), half_room(), "scene", options, Execution{}));
    EXPECT_EQ(saved.options.stop, "change");
    EXPECT_EQ(relight_defaults(saved).stop, "change");
}

/// After a motion all rays are cast anew; what leaves the cell is refused.
TEST(Repetition, MovedObjectsStayInTheCell) {
    const auto scene = std::make_shared<Scene>(half_room());
    scene->mesh.repetition.periods = {Vec3(0, 1.5, 0)};
    settle_repetition(scene->mesh);
    const auto engine = built_over(scene->mesh, test::plugin<Visibility>("cgal"));
    const auto fresh = [] {
        FreshParts parts{test::plugin<Visibility>("cgal"), test::plugin<Basis>("normalized-radial"), {}, false};
        std::string text;
        parts.projection = projection_for(*parts.basis, "", text);
        return parts;
    };
    FreshParts parts = fresh();
    const auto directions = test::plugin<Directions>("fibonacci");
    Discretisation discretisation =
        discretise(scene->mesh, std::make_shared<SiteSet>(test::poisson_sites(scene->mesh, 0.35)), parts.basis,
                   parts.projection, false, 1, Execution{});
    LightTransport transport = gathered({scene->mesh, *engine}, discretisation.points, *discretisation.surfels,
                                        *directions, 32, 1, Execution{});
    const RadiositySystem system(SystemParts{scene, engine, directions, test::plugin<Solver>("krylov"),
                                             std::move(discretisation), std::move(transport), 1});
    std::vector<char> marked;
    for (Index t = 0; t < scene->mesh.triangles.size(); ++t) {
        const Vec3 centre = scene->mesh.at(t, 1.0 / 3, 1.0 / 3).position;
        marked.push_back(centre.x() > 0.3 && centre.x() < 0.7 && centre.y() > 0.3 && centre.y() < 0.9 &&
                                 centre.z() > 0.01 && centre.z() < 0.6
                             ? 1
                             : 0);
    }
    RecastCount count;
    const auto moved = moved_system(system, marked, {Eigen::Matrix3d::Identity(), Vec3(-0.35, 0.1, 0)}, fresh(), 32,
                                    count, Execution{});
    const Discretisation& now = moved->discretisation();
    const LightTransport anew = gathered(moved->tracer(), now.points, *now.surfels, *directions, 32, 1, Execution{});
    EXPECT_EQ(anew.sky, moved->transport().sky);
    EXPECT_EQ(count.kept, 0U);
    EXPECT_THROW(
        moved_system(system, marked, {Eigen::Matrix3d::Identity(), Vec3(-0.45, 0, 0)}, fresh(), 32, count, Execution{}),
        InputError)
        << "through the plane of symmetry";
}

TEST(Repetition, IsRefusedWhereItCannotBeServed) {
    Scene scene = half_room();
    BakeOptions options = lit::quick(0.5);
    options.transport = "pairwise";
    EXPECT_THROW(lit::baked(scene, options), UsageError);
    scene.materials[1].mirror = Rgb::Constant(0.5);
    scene.materials[1].reflectance = Rgb::Zero();
    EXPECT_THAT(test::refusal_of([&] { lit::baked(scene, lit::quick(0.5)); }, "mirrors"), HasSubstr("has mirrors"));
}

} // namespace
} // namespace difusa::repetition_invariants_test
