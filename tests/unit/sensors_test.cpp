// Sensors in mid-air against closed forms, and grids of them.
#include <difusa/bake.h>
#include <difusa/bake/sensing.h>
#include <difusa/bake/sensor_grid.h>
#include <difusa/core/error.h>
#include <difusa/output/bake_files.h>
#include <difusa/output/point_table.h>
#include <difusa/rays/lambert.h>

#include <support/lit_scenes.h>
#include <support/plugins.h>
#include <support/refusal.h>
#include <support/rooms.h>
#include <support/sited.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace difusa::sensors_test {
namespace {

using testing::HasSubstr;

constexpr double pi = std::numbers::pi;
const std::vector<SensorKind> kinds{SensorKind::planar, SensorKind::spherical, SensorKind::cylindrical};

BakeResult coarse_bake(const Scene& scene, BakeOptions options = {}) {
    options.sites = options.spacing > 0.0 ? 0 : 200;
    options.rays = 64;
    options.error_points = options.error_points.value_or(0);
    return bake(test::registry(), scene, "scene", options, Execution{});
}

SensorReadings read(const BakeResult& result, const std::vector<Sensor>& sensors, std::size_t rays = 1024,
                    unsigned threads = 1) {
    return read_sensors(result.field(), sensors, rays, nullptr, 1, Execution{threads});
}

std::vector<Sensor> each_kind(const Vec3& position, const Vec3& axis) {
    std::vector<Sensor> sensors;
    for (const SensorKind kind : kinds) {
        sensors.push_back({position, axis, kind});
    }
    return sensors;
}

/// A black floor of 8 by 8 under z = 0, with nothing else.
Scene black_floor() {
    return test::uniform_scene(test::moved(test::grid(8, 8, 8.0, 8.0), 1.0, Vec3(-4, -4, 0)), 0.0, 0.0);
}

TEST(Sensors, InAUniformDomeAllKindsMeasureItsIrradiance) {
    // A radiance of 1 / pi from everywhere: integrals of pi, 4 pi / 4 and pi^2 / pi. Nothing but a speck of dust,
    // 1e-14 of the view, is in the way.
    Scene scene = test::uniform_scene(test::grid(1, 1, 1e-6, 1e-6), 0.0, 0.0);
    scene.sky = Rgb::Ones();
    const BakeResult result = coarse_bake(scene);
    for (const Vec3& axis : {Vec3(Vec3::UnitZ()), Vec3(Vec3::UnitX()), Vec3(Vec3(1, -2, 3).normalized())}) {
        const SensorReadings readings = read(result, each_kind({0.5, 3.0, 4.0}, axis));
        EXPECT_LT((readings.H.array() - 1.0).abs().maxCoeff(), 1e-12);
        EXPECT_LT(readings.noise.maxCoeff(), 1e-12);
        EXPECT_TRUE(readings.H.isApprox(readings.H_direct));
    }
}

/// An open black box under an even sky. Within it nothing blocks, and its surface is convex; a sensor beside it, from
/// which one wall hides all of the rest, misses the form factor of that wall, and one above its rim that looks away
/// from it misses nothing.
TEST(Sensors, BesideAnOpenBoxSeeItsWallsFromBehind) {
    Mesh mesh = test::box(Vec3(1, 1, 1), 1, true);
    std::erase_if(mesh.triangles, [&](const auto& triangle) {
        return std::all_of(triangle.begin(), triangle.end(), [&](Index p) { return mesh.points[p].z() == 1.0; });
    });
    Scene scene =
        test::uniform_scene(test::make_mesh(mesh.points, {mesh.triangles.begin(), mesh.triangles.end()}), 0.0, 0.0);
    scene.sky = Rgb::Ones();
    ASSERT_TRUE(scene.mesh.convex);
    BakeOptions options;
    options.at = {{Vec3(1.2, 0.5, 0.5), Vec3(-Vec3::UnitX())}, {Vec3(1.2, 0.5, 1.5), Vec3(Vec3::UnitX())}};
    const BakeResult result = coarse_bake(scene, options);
    const Vec3 x = options.at.front().position;
    const std::array<Vec3, 4> wall{Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(1, 1, 1), Vec3(1, 0, 1)};
    const double hidden = lambert_form_factor(x, -Vec3::UnitX(), wall);
    ASSERT_GT(hidden, 0.5);
    ASSERT_EQ(result.readings.H.rows(), 2);
    // The standard error of 4096 independent rays, of which even ones stay well below.
    EXPECT_NEAR(result.readings.H(0, 0), 1.0 - hidden, std::sqrt(hidden * (1.0 - hidden) / 4096.0));
    EXPECT_NEAR(result.readings.H(1, 0), 1.0, 1e-12);
    // Of a closed room there is no such place.
    EXPECT_THROW(coarse_bake(test::uniform_scene(test::box(Vec3(1, 1, 1), 1, true), 0.5, 1.0), options), InputError);
}

/// A sensor on the back of a sheet that a sun shines on from behind, whether or not the back is a surface of its own;
/// there is nothing else on that side.
TEST(Sensors, OnTheBackOfASheet) {
    for (const bool two_sided : {false, true}) {
        Mesh mesh = test::moved(test::grid(1, 1, 10.0, 10.0), 1.0, Vec3(-5, -5, 0));
        if (two_sided) {
            mesh = test::together(mesh, test::moved(test::grid(1, 1, 10.0, 10.0, true), 1.0, Vec3(-5, -5, 0)));
        }
        Scene scene = test::uniform_scene(std::move(mesh), 0.5, 0.0);
        scene.suns.push_back({-Vec3::UnitZ(), Rgb::Constant(100.0)});
        scene.sky = Rgb::Ones();
        BakeOptions options;
        options.at = {{Vec3(0.1, 0, 0), Vec3(-Vec3::UnitZ())}};
        const BakeResult result = coarse_bake(scene, options);
        ASSERT_EQ(result.listed.size(), two_sided ? 1U : 0U);
        EXPECT_NEAR(two_sided ? result.listed_values.H(0, 0) : result.readings.H(0, 0), 101.0, 1e-9) << two_sided;
        // Tilted by 80° from the normal of the back: it sees this share of the sky, and in place of the rest the back,
        // which reflects half of what it receives if it is a surface.
        const double tilt = 80.0 * pi / 180.0, share = 0.5 * (1.0 + std::cos(tilt)), back = two_sided ? 50.5 : 0.0;
        options.at = {{Vec3(0.1, 0, 0), Vec3(std::sin(tilt), 0, -std::cos(tilt))}};
        const BakeResult tilted = coarse_bake(scene, options);
        ASSERT_EQ(tilted.readings.H.rows(), 1);
        EXPECT_NEAR(tilted.readings.H(0, 0), 100.0 * std::cos(tilt) + share + (1.0 - share) * back,
                    std::abs(back - 1.0) * std::sqrt(share * (1.0 - share) / 4096.0)); // as of independent rays
    }
}

TEST(Sensors, RefuseWhatIsNoPlace) {
    const Scene scene = black_floor();
    for (const ListedPoint& place :
         {ListedPoint{Vec3(0, 0, std::nan("")), std::nullopt}, ListedPoint{Vec3(0, 0, 1), Vec3(0, 0, 2)},
          ListedPoint{Vec3(0, 0, 1), Vec3::Zero()}, ListedPoint{Vec3(0, 0, 1), Vec3::Constant(std::nan(""))}}) {
        BakeOptions options;
        options.at = {place};
        EXPECT_THROW(coarse_bake(scene, options), UsageError);
        options.at.clear();
        options.goals = {{"desk", {}, {}, {place}}};
        EXPECT_THROW(coarse_bake(scene, options), UsageError);
    }
}

TEST(Sensors, InAFurnaceAllKindsMeasureItsRadiosity) {
    const BakeResult result = coarse_bake(test::uniform_scene(test::l_room(), 0.5, 0.5));
    const SensorReadings readings = read(result, each_kind({0.5, 1.7, 0.4}, Vec3(1, 1, 1).normalized()), 256);
    EXPECT_LT((readings.H.array() - 1.0).abs().maxCoeff(), 1e-6); // the solver's tolerance
}

/// A large black wall y = 0 with a square window, behind which the sky is, and a point light in front of it. Few rays
/// meet the window, and none has to do with the lamp.
struct Window {
    static constexpr double far = 2000.0, sky = 3.0, power = 0.01;
    std::optional<BakeResult> result;
    std::vector<Sensor> sensors;
    std::vector<double> exact;

    explicit Window(double half) {
        const auto from_to = [](double x0, double x1, double z0, double z1) {
            return rectangle(Vec3(x0, 0, z0), Vec3(0, 0, z1 - z0), Vec3(x1 - x0, 0, 0));
        };
        Mesh mesh = from_to(-far, -half, -far, far);
        add(mesh, from_to(half, far, -far, far), 0);
        add(mesh, from_to(-half, half, -far, -half), 0);
        add(mesh, from_to(-half, half, half, far), 0);
        Scene scene = test::uniform_scene(std::move(mesh), 0.0, 0.0);
        scene.sky = Rgb::Constant(sky);
        PointLight lamp;
        lamp.position = Vec3(0.0, 0.5, 0.0);
        lamp.intensity = Rgb::Constant(power);
        scene.point_lights.push_back(lamp);
        result = coarse_bake(scene);
        RandomStream stream(1, "sensors");
        for (int i = 0; i < 100; ++i) {
            const Vec3 x(4.0 * stream.uniform() - 2.0, 5.0 + 5.0 * stream.uniform(), 4.0 * stream.uniform() - 2.0);
            const Vec3 n = Vec3(stream.uniform() - 0.5, -0.3, stream.uniform() - 0.5).normalized();
            const auto seen = [&](double size) {
                return lambert_form_factor(x, n,
                                           std::array<Vec3, 4>{Vec3(-size, 0, -size), Vec3(-size, 0, size),
                                                               Vec3(size, 0, size), Vec3(size, 0, -size)});
            };
            const Vec3 way = lamp.position - x;
            sensors.push_back({x, n, SensorKind::planar});
            exact.push_back(sky * (1.0 - seen(far) + seen(half)) +
                            power * std::max(0.0, n.dot(way.normalized())) / way.squaredNorm());
        }
    }

    SensorReadings read(const SensorRays& rays) const {
        return read_sensors(result->field(), sensors, rays, nullptr, 1, Execution{});
    }
};

/// By chance all parts of the rays of a sensor may meet the window as often: the noise has to tell all the same.
TEST(Sensors, FarFromAWindow) {
    const Window window(0.75);
    for (const SensorRays rays : {SensorRays(1024), SensorRays(4096), SensorRays(4096, 65536)}) {
        const SensorReadings read = window.read(rays);
        double relative = 0.0, in_noises = 0.0;
        for (std::size_t i = 0; i < window.sensors.size(); ++i) {
            const auto row = static_cast<Eigen::Index>(i);
            const double off = read.H(row, 0) - window.exact[i];
            relative += std::pow(off / window.exact[i], 2) / 100.0;
            in_noises += std::pow(off / read.noise(row, 0), 2) / 100.0;
            EXPECT_LT(std::abs(off), 5.0 * read.noise(row, 0)); // about one in a million, if normally distributed
        }
        // The root mean square of a hundred is 1 ± 0.07, and the noise is known to some ten per cent.
        EXPECT_LT(std::sqrt(in_noises), 1.3);
        if (rays.most > 4096) {
            EXPECT_LT(std::sqrt(relative), 0.02); // as the noise is to be
        }
    }
}

/// Rays of most sensors miss the window at first. More rays must not be a matter of having met it.
TEST(Sensors, AreRightInTheMeanFarFromASmallWindow) {
    const Window window(0.08);
    const SensorReadings read = window.read({4096, 65536});
    Eigen::ArrayXd off(100);
    for (Eigen::Index i = 0; i < off.size(); ++i) {
        off[i] = read.H(i, 0) - window.exact[static_cast<std::size_t>(i)];
    }
    EXPECT_GT(read.rays, 100U * 8192U);
    EXPECT_LT(std::abs(off.mean()), 4.0 * std::sqrt((off - off.mean()).square().mean() / 99.0));
}

TEST(Sensors, UnderAPointLight) {
    Scene scene = black_floor();
    PointLight lamp;
    lamp.position = Vec3(1.0, 0.0, 3.0);
    lamp.intensity = Rgb(8.0, 4.0, 2.0);
    scene.point_lights.push_back(lamp);
    const BakeResult result = coarse_bake(scene);
    const Vec3 place(-0.5, 0.7, 1.0), way = lamp.position - place;
    const double r2 = way.squaredNorm(), cosine = way.normalized().z(), sine = std::sqrt(1.0 - cosine * cosine);
    const SensorReadings readings = read(result, each_kind(place, Vec3::UnitZ()));
    for (Eigen::Index c = 0; c < 3; ++c) {
        const double I = lamp.intensity[c];
        EXPECT_NEAR(readings.H(0, c), I * cosine / r2, 1e-12 * I);
        // The mean of max(0, n.w) over n equal angles is off by at most the factor (pi / n) cot(pi / n).
        EXPECT_NEAR(readings.H(2, c), I * sine / (pi * r2), (1.0 - pi / 32 / std::tan(pi / 32)) * I / (pi * r2));
    }
    // Randomly turned lattices are right in the mean.
    const std::vector<Sensor> many(100, Sensor{place, Vec3::UnitZ(), SensorKind::spherical});
    const SensorReadings spheres = read(result, many, 256);
    const Eigen::ArrayXd ratio = spheres.H.col(0).array() / (lamp.intensity[0] / (4.0 * r2));
    EXPECT_NEAR(ratio.mean(), 1.0, 4.0 * std::sqrt((ratio - 1.0).square().mean() / 100.0));
    EXPECT_LT((ratio - 1.0).abs().maxCoeff(), 0.02);
    // The noise tells how far they are off: root mean squares, from a hundred differences.
    const double noise = std::sqrt(spheres.noise.col(0).array().square().mean()) /
                         (std::sqrt(lamp.intensity.square().mean()) / (4.0 * r2));
    EXPECT_NEAR(std::sqrt((ratio - 1.0).square().mean()) / noise, 1.0, 0.4);
    // Behind the floor of a horizontal sensor that faces down is nothing.
    EXPECT_EQ(read(result, {{place, -Vec3::UnitZ(), SensorKind::planar}}).H.maxCoeff(), 0.0);
}

TEST(Sensors, OverALitSquare) {
    Scene scene = black_floor();
    Material lamp;
    lamp.emission = Rgb::Ones();
    scene.materials.push_back(lamp);
    for (Index t = 0; t < scene.mesh.triangles.size(); ++t) { // [0, 1]^2
        const Vec3 centre = scene.mesh.at(t, 1.0 / 3.0, 1.0 / 3.0).position;
        if (centre.x() > 0.0 && centre.x() < 1.0 && centre.y() > 0.0 && centre.y() < 1.0) {
            scene.mesh.material[t] = 1;
        }
    }
    const BakeResult result = coarse_bake(scene);
    // Facing down, at the height h above a corner: the form factor of a square on a parallel small plane.
    const double h = 0.5, side = std::sqrt(1.0 + h * h);
    const double F = std::atan(1.0 / side) / (pi * side);
    const SensorReadings readings = read(result, {{Vec3(0, 0, h), -Vec3::UnitZ(), SensorKind::planar}});
    EXPECT_NEAR(readings.H(0, 0), F, 1e-12);
    // A sphere: a quarter of the radiance 1 / pi times the solid angle, asin(1 / (1 + h^2)) above a corner.
    const std::vector<Sensor> many(50, Sensor{Vec3(0, 0, h), Vec3::UnitZ(), SensorKind::spherical});
    const Values H = read(result, many, 256).H;
    const double exact = std::asin(1.0 / (1.0 + h * h)) / (4.0 * pi);
    EXPECT_NEAR(H.col(0).mean() / exact, 1.0, 4.0 * std::sqrt((H.col(0).array() / exact - 1.0).square().mean() / 50.0));
    EXPECT_LT((H.col(0).array() / exact - 1.0).abs().maxCoeff(), 0.03);
}

TEST(Sensors, TheSameBitsOnAnyNumberOfThreadsAndTheSumOfTheGroups) {
    Scene scene = lit::scene_of(lit::plain_box({0, 0, 0}, {2, 3, 1}, 2, Front::inside), 0.5);
    for (const char* name : {"one", "two"}) {
        PointLight lamp;
        lamp.position = Vec3(1.0, name[0] == 'o' ? 1.0 : 2.0, 0.8);
        lamp.intensity = Rgb::Ones();
        lamp.name = name;
        scene.point_lights.push_back(lamp);
    }
    BakeOptions options;
    options.light_groups = true;
    const BakeResult result = coarse_bake(scene, options);
    std::vector<Sensor> sensors = each_kind({0.3, 0.4, 0.5}, Vec3::UnitZ());
    sensors.push_back({{1.3, 2.4, 0.2}, Vec3::UnitX(), SensorKind::planar});
    const SensorReadings one = read(result, sensors, 128, 1), three = read(result, sensors, 128, 3);
    EXPECT_EQ(one.H, three.H);
    EXPECT_EQ(one.noise, three.noise);
    ASSERT_EQ(one.groups.size(), 2U);
    EXPECT_LT((one.groups[0].H + one.groups[1].H - one.H).cwiseAbs().maxCoeff(), 1e-12 * one.H.maxCoeff());
    EXPECT_GT(one.H_indirect.minCoeff(), 0.0);
    // Of a field that undershoots, groups are raised to 0 as their sum is.
    FieldParts parts = result.field().parts();
    parts.smooth *= -1.0;
    const SensorReadings raised = read_sensors(Field(std::move(parts)), sensors, 128, nullptr, 1, Execution{});
    EXPECT_EQ(raised.H_indirect, Values(Values::Zero(raised.H.rows(), 3)));
    EXPECT_EQ(raised.H_direct, one.H_direct);
    EXPECT_LT((raised.groups[0].H + raised.groups[1].H - raised.H).cwiseAbs().maxCoeff(), 1e-12 * one.H.maxCoeff());
}

TEST(Sensors, TheirErrorsAreEstimated) {
    Scene scene = lit::scene_of(lit::plain_box({0, 0, 0}, {2, 3, 1}, 2, Front::inside), 0.7);
    scene.mesh.convex = false; // as it is for nearly all scenes
    PointLight lamp;
    lamp.position = Vec3(1.0, 1.0, 0.8);
    lamp.intensity = Rgb::Ones();
    scene.point_lights.push_back(lamp);
    BakeOptions options;
    options.spacing = 0.4;
    options.error_points = 256;
    options.sensor = "horizontal";
    options.final_gather = 256;
    for (double y = 0.25; y < 3.0; y += 0.5) {
        options.at.push_back({Vec3(0.6, y, 0.3), {}});
    }
    const BakeResult result = coarse_bake(scene, options);
    options.spacing = 0.1;
    options.output_spacing = 1e30; // a final gather at the sensors is what is wanted
    options.final_gather = 16384;
    options.rays = 1024;
    const BakeResult fine = bake(test::registry(), scene, "scene", options, Execution{});
    const Values off = (result.readings.H - fine.readings.H).leftCols(1); // grey
    const double rms = std::sqrt(off.squaredNorm() / 6.0), told = std::sqrt(result.readings.error.squaredNorm() / 6.0);
    EXPECT_GT(told, 0.4 * rms);
    EXPECT_LT(told, 10.0 * rms);
    EXPECT_LT(fine.readings.error.maxCoeff(), 0.3 * told);
    EXPECT_TRUE((result.readings.error.array() >= result.readings.noise.array()).all());
}

std::vector<Vec3> grid_places(const Scene& scene, const SensorGrid& grid) {
    return places_of_grid(grid, scene).positions;
}

std::string refused(const Scene& scene, const SensorGrid& grid) {
    try {
        places_of_grid(grid, scene);
    } catch (const UsageError& error) {
        return error.what();
    }
    ADD_FAILURE() << "accepted: " << grid.on;
    return "";
}

TEST(SensorGrids, CellsAreNoLongerThanTheSpacingAndKeepTheMargin) {
    Scene scene = test::uniform_scene(test::grid(3, 2, 3.0, 1.0), 0.5, 0.0);
    scene.materials[0].name = "floor";
    const std::vector<Vec3> places = grid_places(scene, {"floor", 0.8, 0.5, 0.1});
    ASSERT_EQ(places.size(), 6U * 2U); // 2.8 by 0.8
    EXPECT_LT((places[0] - Vec3(0.1 + 1.4 / 6.0, 0.3, 0.8)).norm(), 1e-12);
    EXPECT_LT((places[1] - places[0] - Vec3(2.8 / 6.0, 0.0, 0.0)).norm(), 1e-12);
    EXPECT_LT((places[6] - places[0] - Vec3(0.0, 0.4, 0.0)).norm(), 1e-12);
    // A face by its number; one sensor if the spacing is larger than the face.
    EXPECT_EQ(grid_places(scene, {"0", 0.0, 0.1, 0.0}).size(), 9U + 7U + 5U + 3U + 1U); // of a triangle
    EXPECT_EQ(grid_places(scene, {"floor", 0.0, 9.0, 0.0}).size(), 1U);
    EXPECT_THAT(refused(scene, {"floor", 0.0, 0.5, 0.6}), HasSubstr("the margin of 0.6 leaves nothing"));
    EXPECT_THAT(refused(scene, {"wall", 0.0, 0.5, 0.0}), HasSubstr("there is no material `wall`. There are: floor"));
    EXPECT_THAT(refused(scene, {"floor", 0.0, 1e-4, 0.0}), HasSubstr("more than a million"));
}

TEST(SensorGrids, FollowTheOutlineOfTheFace) {
    Scene scene = test::uniform_scene(test::l_room(), 0.5, 0.0);
    scene.mesh.original_face.assign(scene.mesh.triangles.size(), 7);
    Mesh& mesh = scene.mesh;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        mesh.original_face[t] = mesh.normals[t].z() > 0.5 ? 3 : 7;
    }
    const std::vector<Vec3> places = grid_places(scene, {"3", 0.5, 0.25, 0.0});
    EXPECT_EQ(places.size(), 3U * 16U); // three of the four unit squares
    for (const Vec3& p : places) {
        EXPECT_FALSE(p.x() > 1.0 && p.y() > 1.0);
        EXPECT_NEAR(p.z(), 0.5, 1e-12);
    }
    for (const Vec3& p : grid_places(scene, {"3", 0.5, 0.1, 0.2})) { // the inner corner, too
        EXPECT_GT((p.head<2>() - Eigen::Vector2d(1, 1)).norm(), 0.2 - 1e-9);
        EXPECT_GT(std::min(p.x(), p.y()), 0.2 - 1e-9);
    }
    EXPECT_THAT(refused(scene, {"7", 0.5, 0.25, 0.0}), HasSubstr("not flat"));
}

/// However the face lies in its plane.
TEST(SensorGrids, TurnWithTheFace) {
    for (const double degrees : {10.0, 33.0, 45.0, 80.0, 123.0, 200.0}) {
        const Eigen::AngleAxisd turn(degrees * pi / 180.0, Vec3::UnitZ());
        for (const Mesh& mesh : {test::grid(3, 2, 3.0, 1.0), test::l_room()}) {
            Scene scene = test::uniform_scene(mesh, 0.5, 0.0);
            scene.mesh.original_face.assign(scene.mesh.triangles.size(), 7);
            for (Index t = 0; t < scene.mesh.triangles.size(); ++t) {
                scene.mesh.original_face[t] = scene.mesh.normals[t].z() > 0.5 ? 3 : 7;
            }
            const std::vector<Vec3> before = grid_places(scene, {"3", 0.5, 0.3, 0.1});
            for (Vec3& point : scene.mesh.points) {
                point = turn * point;
            }
            scene.mesh.derive();
            const std::vector<Vec3> after = grid_places(scene, {"3", 0.5, 0.3, 0.1});
            ASSERT_EQ(after.size(), before.size());
            for (const Vec3& p : before) {
                EXPECT_TRUE(std::any_of(after.begin(), after.end(), [&](const Vec3& q) {
                    return (q - turn * p).norm() < 1e-9;
                })) << degrees;
            }
        }
    }
}

/// A disc of slivers, each of which spans many cells: the places are those inside all of its sides, by the margin.
TEST(SensorGrids, AreFoundOnSlivers) {
    constexpr int slices = 96;
    std::vector<Vec3> points{Vec3::Zero()};
    std::vector<std::array<Index, 3>> triangles;
    for (Index k = 0; k < slices; ++k) {
        const double angle = 2.0 * pi * k / slices;
        points.emplace_back(std::cos(angle), std::sin(angle), 0.0);
        triangles.push_back({0, 1 + k, 1 + (k + 1) % slices});
    }
    Scene scene = test::uniform_scene(test::make_mesh(points, triangles), 0.5, 0.0);
    scene.materials[0].name = "disc";
    for (const double margin : {0.0, 0.13}) {
        const double side = 2.0 * (1.0 - margin), cells = std::ceil(side / 0.07);
        std::vector<Vec3> expected;
        for (double row = 0.5; row < cells; ++row) {
            for (double column = 0.5; column < cells; ++column) {
                const Vec3 p(margin - 1.0 + column / cells * side, margin - 1.0 + row / cells * side, 0.4);
                double reach = -1.0; // along the normal of a side
                for (int k = 0; k < slices; ++k) {
                    const double angle = 2.0 * pi * (k + 0.5) / slices;
                    reach = std::max(reach, std::cos(angle) * p.x() + std::sin(angle) * p.y());
                }
                if (reach <= std::cos(pi / slices) - margin) {
                    expected.push_back(p);
                }
            }
        }
        const std::vector<Vec3> places = grid_places(scene, {"disc", 0.4, 0.07, margin});
        ASSERT_EQ(places.size(), expected.size());
        EXPECT_GT(places.size(), 400U);
        for (std::size_t i = 0; i < places.size(); ++i) {
            EXPECT_LT((places[i] - expected[i]).norm(), 1e-12);
        }
    }
}

TEST(Places, WithANormalStandWhereTheyAreAndWithoutOneOnTheSurface) {
    Scene scene = black_floor();
    PointLight lamp;
    lamp.position = Vec3(0.0, 0.0, 3.0);
    lamp.intensity = Rgb::Ones();
    scene.point_lights.push_back(lamp);
    BakeOptions options;
    const Vec3 mid(1.1, 0.3, 1.0), floor(1.1, 0.3, 0.0);
    options.at = {{mid, Vec3::UnitZ()}, {mid, {}}, {floor, Vec3::UnitZ()}, {floor, Vec3::UnitX()}};
    options.grids = {{"0", 1.0, 0.6, 0.0}};
    const auto H = [&](const Vec3& p, const Vec3& n) {
        const Vec3 way = lamp.position - p;
        return n.dot(way) / std::pow(way.norm(), 3);
    };
    const BakeResult result = coarse_bake(scene, options);
    ASSERT_EQ(result.listed.size(), 2U);
    EXPECT_THAT(result.listed_number, testing::ElementsAre(1, 2));
    EXPECT_NEAR(result.listed_values.H(0, 0), H(floor, Vec3::UnitZ()), 1e-12);
    EXPECT_NEAR(result.listed_values.H(1, 0), H(floor, Vec3::UnitZ()), 1e-12);
    ASSERT_GE(result.sensors.size(), 3U);
    EXPECT_NEAR(result.readings.H(0, 0), H(mid, Vec3::UnitZ()), 1e-12);
    EXPECT_EQ(result.readings.H(1, 0), 0.0); // away from the lamp
    EXPECT_EQ(result.sensors[2].grid, 0U);
    const GridSummary summary = summary_of_grid(result, 0);
    EXPECT_EQ(summary.count, result.sensors.size() - 2);
    EXPECT_LE(summary.least, summary.mean);
    EXPECT_DOUBLE_EQ(summary.uniformity, summary.least / summary.mean);
    const std::string table = point_table(result);
    EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 1 + 4 + static_cast<long>(summary.count));
    const std::string heading = table.substr(0, table.find('\n'));
    std::istringstream lines(table);
    for (std::string line; std::getline(lines, line);) {
        EXPECT_EQ(std::count(line.begin(), line.end(), ','), std::count(heading.begin(), heading.end(), ',')) << line;
    }

    options.snap = true;
    options.grids.clear();
    options.at.pop_back();
    EXPECT_EQ(coarse_bake(scene, options).listed.size(), 3U);
    options.sensor = "spherical";
    EXPECT_THROW(coarse_bake(scene, options), UsageError); // measures where it stands
    options.snap = false;
    const BakeResult turned = coarse_bake(scene, options); // normals are not used, and that is said
    EXPECT_EQ(turned.sensors.size(), options.at.size());
    EXPECT_THAT(turned.journal.notes(), Contains(HasSubstr("a spherical sensor has none of its own")));
    options.at = {{mid, {}}};
    EXPECT_EQ(coarse_bake(scene, options).sensors.size(), 1U);
    options.sensor = "diagonal";
    EXPECT_THROW(coarse_bake(scene, options), UsageError);
}

TEST(Sensors, UnsoundOnesAndPointsInMidAirAreRefused) {
    const BakeResult result = coarse_bake(black_floor());
    Sensor sensor;
    sensor.position = Vec3(0.5, std::numeric_limits<double>::quiet_NaN(), 0.5);
    EXPECT_THROW(read(result, {sensor}), UsageError);
    sensor.position.y() = 0.5;
    EXPECT_THROW(read(result, {sensor}, 3), UsageError);
    EXPECT_NO_THROW(read(result, {sensor}, 4));
    sensor.axis *= 2.0;
    EXPECT_THROW(read(result, {sensor}), UsageError);

    const SurfacePoint in_mid_air;
    EXPECT_THROW(result.field().at({&in_mid_air, 1}, 0, 1, "place", Execution{}), UsageError);
    EXPECT_THROW(result.field().evaluate_smooth({&in_mid_air, 1}, Execution{}), UsageError);
    EXPECT_THROW(result.field().evaluate({&in_mid_air, 1}, 1, "place", Execution{}), UsageError);
    EXPECT_TRUE(
        result.system->solve(std::span<const std::shared_ptr<const Scene>>(), LightingOptions{}, Execution{}).empty());
    EXPECT_THROW(result.system->solve(nullptr, LightingOptions{}, Execution{}), UsageError);
    Scene without = *result.scene;
    without.materials.clear();
    EXPECT_THROW(result.system->solve(std::make_shared<const Scene>(without), LightingOptions{}, Execution{}),
                 UsageError);
}

} // namespace
} // namespace difusa::sensors_test
