#include <difusa/core/error.h>
#include <difusa/core/parallel.h>
#include <difusa/import/shapes.h>
#include <difusa/lighting/area_lights.h>
#include <difusa/lighting/shadow_batches.h>
#include <difusa/mesh/nearest_surface.h>
#include <difusa/rays/brute_force.h>
#include <difusa/rays/lambert.h>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <meshes.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <numeric>

namespace difusa::area_lights_test {
namespace {

constexpr std::size_t samples = 64;

/// A flat rectangle at height z with the normal ±z.
Mesh rectangle(double x0, double x1, double y0, double y1, double z, bool down = false) {
    return test::moved(test::grid(1, 1, x1 - x0, y1 - y0, down), 1.0, Vec3(x0, y0, z));
}

/// The triangles of `lamp` have the material 1, which emits; the others do not.
Scene scene_of(Mesh mesh, const std::vector<Index>& lamp) {
    Scene scene;
    scene.mesh = std::move(mesh);
    scene.materials.resize(2);
    scene.materials[1].emission = Rgb(1, 2, 3);
    for (const Index t : lamp) {
        scene.mesh.material[t] = 1;
    }
    return scene;
}

/// The irradiance at the points, and what it took.
struct Lit {
    std::vector<Rgb> H, variance;
    std::size_t cast = 0, clear = 0;
};

Lit light(const Scene& scene, const std::vector<Index>& lamps, const std::vector<SurfacePoint>& points,
          std::uint64_t seed = 1, unsigned threads = 1, std::size_t samples_per_round = samples) {
    BruteForceVisibility visibility;
    visibility.build(scene.mesh);
    const AreaLights light(scene, lamps, {scene.mesh, visibility});
    Lit lit;
    lit.H.resize(points.size());
    lit.variance.resize(points.size());
    const std::vector<Index> one_set(scene.materials.size(), 0);
    std::vector<AreaLights::Worker> workers(threads);
    parallel_for(
        points.size(), 16, Execution{threads, nullptr}, [&](std::size_t begin, std::size_t end, unsigned number) {
            for (std::size_t j = begin; j < end; ++j) {
                RandomStream stream(seed, "lamps", j);
                lit.H[j] = Rgb::Zero();
                light.irradiance(points[j], samples_per_round, stream, workers[number], one_set, {&lit.H[j], 1});
                lit.variance[j] = workers[number].variance;
            }
        });
    for (const AreaLights::Worker& worker : workers) {
        lit.cast += worker.cast;
        lit.clear += worker.clear;
    }
    return lit;
}

/// What the site sees of the lamps with nothing in between.
double unblocked(const Mesh& mesh, const std::vector<Index>& lamps, const SurfacePoint& x) {
    double F = 0.0;
    for (const Index t : lamps) {
        F += lambert_form_factor(x.position, x.normal, mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2));
    }
    return F;
}

/// By how much the form factors of a few triangles, summed up in another way, may differ: three terms of up to 1/2
/// each, off by up to 8 units in the last place.
constexpr double rounding = 4 * 3 * 0.5 * 8 * 0x1p-53;

/// Of the first two triangles, which make a rectangle.
SurfacePoint place_at(const Mesh& mesh, const Vec3& position) {
    SurfacePoint nearest;
    for (const Index face : {0U, 1U}) {
        const std::array<double, 3> weight =
            nearest_on_triangle(position, mesh.corner(face, 0), mesh.corner(face, 1), mesh.corner(face, 2));
        const SurfacePoint x = mesh.at(face, weight[1], weight[2]);
        if (face == 0 || (x.position - position).norm() < (nearest.position - position).norm()) {
            nearest = x;
        }
    }
    return nearest;
}

/// n × n places over the two triangles of a rectangle of width w and depth d at height 0, in the middles of cells.
std::vector<SurfacePoint> places(const Mesh& mesh, int n, double w, double d) {
    std::vector<SurfacePoint> points;
    for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
            const double s = (i + 0.5) / n, t = (j + 0.5) / n;
            points.push_back(place_at(mesh, Vec3(s * w, t * d, 0.0)));
        }
    }
    return points;
}

TEST(AreaLights, UnblockedLightIsExactAndNeedsNoRays) {
    const Mesh mesh = test::together(rectangle(0, 1, 0, 1, 0), rectangle(0.2, 0.7, 0.1, 0.3, 0.4, true));
    const std::vector<Index> lamps{2, 3};
    const std::vector<SurfacePoint> points = places(mesh, 20, 1, 1);
    const Lit lit = light(scene_of(mesh, lamps), lamps, points);
    for (std::size_t j = 0; j < points.size(); ++j) {
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(lit.H[j][c], (c + 1) * unblocked(mesh, lamps, points[j]), (c + 1) * rounding);
        }
    }
    EXPECT_EQ(lit.cast, 0U);
    EXPECT_EQ(lit.clear, points.size());
}

/// A blocker that the shadow rays of a place may meet or not, but that hides nothing of the lamp.
TEST(AreaLights, WhatHidesNothingLeavesTheLightExact) {
    Mesh mesh = test::together(rectangle(0, 1, 0, 1, 0), rectangle(0, 1, 0, 1, 1, true));
    mesh = test::together(mesh, rectangle(-3, 0, 0, 1, 0.5)); // its border lies in the plane of the lamp's side
    const std::vector<Index> lamps{2, 3};
    const std::vector<SurfacePoint> points = places(mesh, 16, 1, 1);
    const Lit lit = light(scene_of(mesh, lamps), lamps, points);
    for (std::size_t j = 0; j < points.size(); ++j) {
        EXPECT_NEAR(lit.H[j][0], unblocked(mesh, lamps, points[j]), rounding);
    }
}

/// A globe of many triangles, each of which is evaluated. What is seen of it lies between two balls with the same
/// centre, one in it and one around it, of which a surface element that both are before receives (r / d)² cos.
TEST(AreaLights, AGlobeLightsLikeABall) {
    const double radius = 0.15;
    const Vec3 centre(0.4, 0.6, 0.5);
    Mesh mesh = rectangle(0, 1, 0, 1, 0);
    const Mesh globe = test::moved(sphere(radius, 3, Front::outside), 1.0, centre);
    mesh = test::together(mesh, globe);
    std::vector<Index> lamps(globe.triangles.size());
    std::iota(lamps.begin(), lamps.end(), Index{2});
    double inner = radius;
    for (const Index t : lamps) {
        inner = std::min(inner, mesh.normals[t].dot(mesh.corner(t, 0) - centre));
    }
    ASSERT_GT(inner, 0.99 * radius);
    const std::vector<SurfacePoint> points = places(mesh, 12, 1, 1);
    const Lit lit = light(scene_of(mesh, lamps), lamps, points);
    for (std::size_t j = 0; j < points.size(); ++j) {
        const Vec3 way = centre - points[j].position;
        const double of_unit = way.z() / std::pow(way.norm(), 3); // both balls are wholly above the plane
        EXPECT_LT(lit.H[j][0], radius * radius * of_unit);
        EXPECT_GT(lit.H[j][0], inner * inner * of_unit);
        EXPECT_NEAR(lit.H[j][0], unblocked(mesh, lamps, points[j]), 1e-12);
    }
}

TEST(AreaLights, MaterialsKeepTheirColours) {
    Mesh mesh = test::together(rectangle(0, 1, 0, 1, 0), rectangle(0.1, 0.3, 0.1, 0.3, 0.4, true));
    mesh = test::together(mesh, rectangle(0.6, 0.9, 0.6, 0.9, 0.2, true));
    Scene scene = scene_of(mesh, {2, 3, 4, 5});
    scene.materials.resize(4); // 2 does not emit
    scene.materials[1].emission = Rgb(0, 0, 4);
    scene.materials[3].emission = Rgb(1, 0, 0);
    scene.mesh.material[4] = scene.mesh.material[5] = 3;
    const std::vector<SurfacePoint> points = places(mesh, 8, 1, 1);
    const Lit lit = light(scene, {2, 3, 4, 5}, points);
    for (std::size_t j = 0; j < points.size(); ++j) {
        // The lower one hides a part of the upper one from some places, and nothing hides the lower one.
        EXPECT_NEAR(lit.H[j][0], unblocked(mesh, {4, 5}, points[j]), rounding);
        EXPECT_EQ(lit.H[j][1], 0.0);
        EXPECT_LE(lit.H[j][2], 4.0 * (unblocked(mesh, {2, 3}, points[j]) + rounding));
    }
}

/// What a material adds to its set does not depend on how materials are dealt to sets, not by a bit.
TEST(AreaLights, SetsShareTheLightWithoutChangingIt) {
    Mesh mesh = test::together(rectangle(0, 1, 0, 1, 0), rectangle(0.1, 0.3, 0.1, 0.3, 0.4, true));
    mesh = test::together(mesh, rectangle(0.6, 0.9, 0.6, 0.9, 0.2, true));
    mesh = test::together(mesh, rectangle(0.2, 0.6, 0.2, 0.8, 0.1)); // hides parts of both
    Scene scene = scene_of(mesh, {2, 3, 4, 5});
    scene.materials.resize(4);
    scene.materials[3].emission = Rgb(1, 0, 0);
    scene.mesh.material[4] = scene.mesh.material[5] = 3;
    BruteForceVisibility visibility;
    visibility.build(scene.mesh);
    const AreaLights light(scene, {2, 3, 4, 5}, {scene.mesh, visibility});
    AreaLights::Worker worker;
    int partly_hidden = 0;
    for (const SurfacePoint& x : places(mesh, 12, 1, 1)) {
        const auto by_set = [&](const std::vector<Index>& set_of, std::size_t sets) {
            std::vector<Rgb> H(sets, Rgb::Constant(0.5)); // it adds
            RandomStream stream(1, "sets");
            light.irradiance(x, samples, stream, worker, set_of, H);
            return H;
        };
        const std::vector<Rgb> apart = by_set({9, 1, 9, 0}, 2), other = by_set({9, 0, 9, 2}, 3),
                               one = by_set({0, 0, 0, 0}, 1);
        EXPECT_TRUE((apart[1] == other[0]).all() && (apart[0] == other[2]).all());
        EXPECT_TRUE((other[1] == 0.5).all());
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(apart[0][c] + apart[1][c] - 1.0, one[0][c] - 0.5, 8 * 0x1p-53);
        }
        partly_hidden += apart[1][0] - 0.5 < 0.999 * unblocked(mesh, {2, 3}, x) ? 1 : 0;
    }
    EXPECT_GT(partly_hidden, 10);
}

TEST(AreaLights, ALampLightsNeitherItselfNorWhatIsBehindIt) {
    // A lamp facing up at height 0, a wall above it facing down, and one below it facing up.
    Mesh mesh = test::together(rectangle(0, 1, 0, 1, 0), rectangle(0, 1, 0, 1, 0.5, true));
    mesh = test::together(mesh, rectangle(0, 1, 0, 1, -0.5));
    const std::vector<SurfacePoint> points{mesh.at(0, 0.3, 0.3), mesh.at(2, 0.3, 0.3), mesh.at(4, 0.3, 0.3)};
    const Lit lit = light(scene_of(mesh, {0, 1}), {0, 1}, points);
    EXPECT_EQ(lit.H[0][0], 0.0);
    EXPECT_NEAR(lit.H[1][0], unblocked(mesh, {0, 1}, points[1]), rounding);
    EXPECT_EQ(lit.H[2][0], 0.0);
}

/// A lamp with a back, as a panel below a ceiling: all of its back is in its plane, to one side or the other by
/// rounding. The more so if the panel is tilted, and if the back is seen with a shading normal.
TEST(AreaLights, ALampLightsNoFaceBackToBackWithIt) {
    for (const double degrees : {0.0, 20.0}) {
        Mesh mesh = test::together(rectangle(1.7, 2.3, 2.2, 2.8, 2.69), rectangle(1.7, 2.3, 2.2, 2.8, 2.69, true));
        const Eigen::AngleAxisd turn(degrees * std::numbers::pi / 180.0, Vec3(1, 2, 3).normalized());
        for (Vec3& point : mesh.points) {
            point = turn * point;
        }
        mesh.derive();
        const Scene scene = scene_of(mesh, {2, 3});
        BruteForceVisibility visibility;
        visibility.build(scene.mesh);
        const std::vector<Index> lamps{2, 3};
        const AreaLights lights(scene, lamps, {scene.mesh, visibility});
        AreaLights::Worker worker;
        RandomStream stream(1, "back");
        for (int i = 0; i < 1000; ++i) {
            const double u = stream.uniform();
            SurfacePoint x = scene.mesh.at(i % 2 == 0 ? 0 : 1, u, (1.0 - u) * stream.uniform());
            if (i % 4 > 1) {
                x.normal = (x.normal + 0.1 * (turn * Vec3::UnitX())).normalized();
            }
            Rgb H = Rgb::Zero();
            lights.irradiance(x, samples, stream, worker, std::vector<Index>{0, 0}, {&H, 1});
            EXPECT_EQ(H[2], 0.0);
            EXPECT_EQ(lights.sample(x, {0.5, 0.5, 0.5, 0.5, 0.5}, worker).H[2], 0.0);
            x.face = none; // a sensor on it
            H = Rgb::Zero();
            x.normal = scene.mesh.normals[0];
            lights.irradiance(x, samples, stream, worker, std::vector<Index>{0, 0}, {&H, 1});
            EXPECT_EQ(H[2], 0.0);
        }
    }
}

TEST(AreaLights, APlaceOnALampIsLitByTheOthers) {
    // Two lamps of one material that face each other.
    const Mesh mesh = test::together(rectangle(0, 1, 0, 1, 0), rectangle(0, 1, 0, 1, 1, true));
    const std::vector<Index> lamps{0, 1, 2, 3};
    const SurfacePoint x = mesh.at(0, 0.2, 0.2);
    EXPECT_NEAR(light(scene_of(mesh, lamps), lamps, {x}).H[0][0], unblocked(mesh, {2, 3}, x), rounding);
}

TEST(AreaLights, AScreenThatHidesAllLeavesNothing) {
    for (const bool down : {false, true}) { // backs block as fronts do
        Mesh mesh = test::together(rectangle(0, 1, 0, 1, 0), rectangle(0.2, 0.7, 0.1, 0.3, 0.4, true));
        mesh = test::together(mesh, rectangle(-1, 2, -1, 2, 0.2, down));
        const Lit lit = light(scene_of(mesh, {2, 3}), {2, 3}, places(mesh, 8, 1, 1));
        for (const Rgb& H : lit.H) {
            EXPECT_TRUE((H == 0.0).all());
        }
        EXPECT_EQ(lit.cast, 0U);
        EXPECT_EQ(lit.clear, 64U);
    }
}

/// A lamp over a floor, of which a screen at half its height, of `strips` × 2 triangles, hides what is left of
/// x = 2 border as seen from a place in the middle of the floor, which is on no edge.
struct Screened {
    double border;
    Mesh mesh;
    std::vector<Index> lamps{2, 3};

    Screened(double at, int strips) : border(at) {
        mesh = test::together(rectangle(-2, 2, -2, 2, 0), rectangle(-0.2, 0.2, -0.2, 0.2, 1, true));
        mesh = test::together(mesh, test::moved(test::grid(1, strips, 0.5, 0.5), 1.0, Vec3(border - 0.5, -0.2, 0.5)));
    }
    SurfacePoint place() const { return place_at(mesh, Vec3(0, 0.1, 0)); }
    double all() const { return unblocked(mesh, lamps, place()); }
    double seen() const { return unblocked(rectangle(2 * border, 0.2, -0.2, 0.2, 1, true), {0, 1}, place()); }
};

/// Few triangles in the way: what they leave is known exactly, without a ray.
TEST(AreaLights, AScreenThatHidesAPart) {
    for (const double border : {-0.09, -0.03, 0.0, 0.095}) {
        for (const int strips : {1, 7}) {
            const Screened scene(border, strips);
            const Lit lit = light(scene_of(scene.mesh, scene.lamps), scene.lamps, {scene.place()});
            EXPECT_NEAR(lit.H[0][0], scene.seen(), 1e-15);
            EXPECT_EQ(lit.cast, 0U);
            EXPECT_EQ(lit.clear, 1U);
        }
    }
}

/// Many triangles: rays, which are unbiased also where a twentieth of the lamp is in sight or hidden. (Rounds of rays
/// that stop as soon as two agree see a fifth too little where a twentieth is in sight.)
TEST(AreaLights, PenumbrasBehindManyTrianglesAreUnbiased) {
    constexpr std::size_t count = 4096, few = 16;
    for (const double border : {-0.09, -0.03, 0.09}) {
        const Screened scene(border, 200);
        const Lit lit =
            light(scene_of(scene.mesh, scene.lamps), scene.lamps, std::vector(count, scene.place()), 1, 1, few);
        double mean = 0.0, squares = 0.0;
        for (const Rgb& H : lit.H) {
            const double error = (H[0] - scene.seen()) / scene.all();
            mean += error / count;
            squares += error * error / count;
        }
        double told = 0.0;
        for (const Rgb& variance : lit.variance) {
            told += variance[0] / (scene.all() * scene.all()) / count;
        }
        EXPECT_GT(told, 0.5 * squares); // the law holds for jumps at any angle; along this one, the sequence is better
        EXPECT_LT(told, 4.0 * squares);
        // The ratio of the sums of a round is biased by less than the squared variation of the integrand over the lamp,
        // 1 - 1/(1 + 2 0.2²)² = 0.14 at most, over the samples, times what is in sight.
        const double seen = scene.seen() / scene.all(), ratio = 0.14 * 0.14 / few * std::min(seen, 1.0 - seen);
        EXPECT_NEAR(mean, 0.0, 4.5 * std::sqrt(squares / count) + ratio) << border;
        EXPECT_LT(std::sqrt(squares), std::sqrt(seen * (1.0 - seen) / few)); // that of independent rays
        EXPECT_GE(lit.cast, count * AreaLights::shadow_batches(few).all_rays(false));
        EXPECT_LE(lit.cast, count * AreaLights::shadow_batches(few).all_rays(true));
    }
}

/// Two lamps, one of which is behind too much: the other is exact all the same.
TEST(AreaLights, RaysAreCastToThoseLightsAloneThatNeedThem) {
    const Screened screened(-0.03, 200);
    const Mesh mesh = test::together(screened.mesh, rectangle(1.2, 1.4, -0.1, 0.1, 1, true));
    const auto last = static_cast<Index>(mesh.triangles.size() - 1);
    Scene scene = scene_of(mesh, screened.lamps);
    scene.materials.resize(3);
    scene.materials[2].emission = Rgb(0, 0, 7);
    scene.materials[1].emission = Rgb(1, 0, 0);
    scene.mesh.material[last - 1] = scene.mesh.material[last] = 2;
    for (const std::vector<Index>& lamps : {std::vector<Index>{last - 1, last, 2, 3}, {2, 3, last - 1, last}}) {
        const Lit lit = light(scene, lamps, {screened.place()});
        EXPECT_NEAR(lit.H[0][2], 7.0 * unblocked(mesh, {last - 1, last}, screened.place()), 7.0 * rounding);
        EXPECT_NEAR(lit.H[0][0], screened.seen(), 4.5 * std::sqrt(0.25 / samples) * screened.all());
        EXPECT_GT(lit.cast, 0U);
    }
}

/// Bright lamps behind a wall, too many to be looked at, and a thousandth as much light in plain sight.
TEST(AreaLights, DimLampsAreNotHiddenByBrightOnes) {
    const int n = 5;
    const Mesh bright = test::moved(test::grid(n, n, 0.4, 0.4, true), 1.0, Vec3(-0.9, 0.3, 1));
    Mesh mesh = test::together(rectangle(0, 1, 0, 1, 0), rectangle(0.4, 0.6, 0.4, 0.6, 1, true));
    mesh = test::together(mesh, bright);
    std::vector<Index> lamps(2 + bright.triangles.size());
    std::iota(lamps.begin(), lamps.end(), Index{2});
    const std::vector<Index> in_sight{2, 3};
    mesh = test::together(mesh, test::moved(test::grid(1, 200, 2.0, 2.0), 1.0, Vec3(-1.7, -0.5, 0.5))); // below them
    Scene scene = scene_of(mesh, in_sight);
    scene.materials.resize(3);
    scene.materials[1].emission = Rgb(0, 1, 0);
    scene.materials[2].emission = Rgb(1000, 0, 0);
    for (Index t = 4; t < 4 + bright.triangles.size(); ++t) {
        scene.mesh.material[t] = 2;
    }
    const std::vector<SurfacePoint> points = places(mesh, 12, 1, 1);
    const Lit lit = light(scene, lamps, points);
    EXPECT_GT(lit.cast, 0U);
    for (std::size_t j = 0; j < points.size(); ++j) {
        if (points[j].position.x() > 0.5) { // from there, the wall hides all of them, and nothing of the other
            EXPECT_EQ(lit.H[j][0], 0.0);
            EXPECT_NEAR(lit.H[j][1], unblocked(mesh, in_sight, points[j]), rounding);
        }
    }
}

/// A red lamp in penumbra and a blue one in plain sight, both of which need rays: the noise is that of the red one.
TEST(AreaLights, NoiseIsThatOfTheColourInPenumbra) {
    constexpr std::size_t count = 2048, few = 64;
    const Screened screened(0.03, 200);
    const Mesh blue =
        test::moved(test::grid(5, 5, 0.4, 0.4, true), 1.0, Vec3(1.2, -0.2, 1)); // too many to be looked at
    const Mesh mesh = test::together(screened.mesh, blue);
    std::vector<Index> lamps{2, 3};
    Scene scene = scene_of(mesh, {2, 3});
    scene.materials.resize(3);
    scene.materials[1].emission = Rgb(1, 0, 0);
    scene.materials[2].emission = Rgb(0, 0, 20);
    for (auto t = static_cast<Index>(screened.mesh.triangles.size()); t < mesh.triangles.size(); ++t) {
        scene.mesh.material[t] = 2;
        lamps.push_back(t);
    }
    const Lit lit = light(scene, lamps, std::vector(count, screened.place()), 1, 1, few);
    double squares = 0.0, told = 0.0;
    for (std::size_t j = 0; j < count; ++j) {
        EXPECT_NEAR(lit.H[j][2], 20.0 * unblocked(mesh, {lamps.begin() + 2, lamps.end()}, screened.place()), 1e-12);
        EXPECT_NEAR(lit.variance[j][2], 0.0, 1e-24);
        squares += std::pow(lit.H[j][0] - screened.seen(), 2) / count;
        told += lit.variance[j][0] / count;
    }
    EXPECT_GT(told, 0.5 * squares);
    EXPECT_LT(told, 4.0 * squares);
}

/// Unit squares at z = 0 and 1 with a blocker [0,1/2]² at z = 1/2: the form factor is known.
TEST(AreaLights, BlockedSquares) {
    Mesh mesh = test::together(rectangle(0, 1, 0, 1, 0), rectangle(0, 1, 0, 1, 1, true));
    mesh = test::together(mesh, rectangle(0, 0.5, 0, 0.5, 0.5));
    const int n = 64;
    const Lit lit = light(scene_of(mesh, {2, 3}), {2, 3}, places(mesh, n, 1, 1));
    double mean = 0.0;
    for (const Rgb& H : lit.H) {
        mean += H[0] / (n * n);
    }
    // The rule of middles, for an irradiance that has kinks but no jump: its slope is at most 1, so a cell that has one
    // is off by less than 1/(4 n); the kinks along the shadows of the four borders cross 4 n cells each at most.
    EXPECT_NEAR(mean, 0.1498686718, 4.0 * n / (n * n) / (4.0 * n) / 4.0);
    EXPECT_EQ(lit.cast, 0U);
}

TEST(AreaLights, SameBitsForAnyNumberOfThreads) {
    Mesh mesh = test::together(rectangle(0, 1, 0, 1, 0), rectangle(0, 1, 0, 1, 1, true));
    mesh = test::together(mesh, test::moved(test::grid(6, 6, 0.5, 0.5), 1.0, Vec3(0, 0, 0.5)));
    const Scene scene = scene_of(mesh, {2, 3});
    const std::vector<SurfacePoint> points = places(mesh, 16, 1, 1);
    const Lit one = light(scene, {2, 3}, points, 7, 1), other_seed = light(scene, {2, 3}, points, 8, 1);
    bool seed_matters = false;
    for (const unsigned threads : {2U, 5U}) {
        const Lit many = light(scene, {2, 3}, points, 7, threads);
        EXPECT_EQ(many.cast, one.cast);
        for (std::size_t j = 0; j < points.size(); ++j) {
            EXPECT_TRUE((many.H[j] == one.H[j]).all());
            seed_matters = seed_matters || other_seed.H[j][0] != one.H[j][0];
        }
    }
    EXPECT_TRUE(seed_matters);
}

TEST(AreaLights, TheSizeOfTheSceneDoesNotMatter) {
    Mesh mesh = test::together(rectangle(0, 1, 0, 1, 0), rectangle(0, 1, 0, 1, 1, true));
    mesh = test::together(mesh, rectangle(0, 0.5, 0, 0.5, 0.5));
    const std::vector<SurfacePoint> points = places(mesh, 8, 1, 1);
    const Lit one = light(scene_of(mesh, {2, 3}), {2, 3}, points);
    for (const double scale : {0x1p-20, 0x1p20}) {
        std::vector<SurfacePoint> scaled = points;
        for (SurfacePoint& x : scaled) {
            x.position *= scale;
        }
        const Lit other = light(scene_of(test::moved(mesh, scale, Vec3::Zero()), {2, 3}), {2, 3}, scaled);
        EXPECT_EQ(other.cast, one.cast);
        for (std::size_t j = 0; j < points.size(); ++j) {
            EXPECT_NEAR(other.H[j][0], one.H[j][0], 1e-14) << scale;
        }
    }
}

/// Of more than 4096 lamps some stand for others: in the mean that makes no difference.
TEST(AreaLights, ManyLampsAreExactInTheMean) {
    const Mesh ceiling = test::moved(test::grid(46, 46, 1.0, 1.0, true), 1.0, Vec3::UnitZ());
    Mesh mesh = test::together(rectangle(0, 1, 0, 1, 0), ceiling);
    std::vector<Index> lamps(ceiling.triangles.size());
    std::iota(lamps.begin(), lamps.end(), Index{2});
    mesh.convex = true; // so that no rays are cast
    for (const Vec3& position : {Vec3(0.8, 0.7, 0.0), Vec3(0.3, 0.4, 0.9)}) {
        SurfacePoint x = place_at(mesh, position);
        x.position = position; // above the floor
        const double exact = unblocked(mesh, lamps, x);
        const std::size_t count = 100;
        const Lit lit = light(scene_of(mesh, lamps), lamps, std::vector(count, x));
        double mean = 0.0, squares = 0.0;
        for (const Rgb& H : lit.H) {
            mean += H[0] / exact / static_cast<double>(count);
            squares += std::pow(H[0] / exact - 1.0, 2) / static_cast<double>(count);
        }
        const double deviation = std::sqrt(squares);
        EXPECT_NEAR(mean, 1.0, 4.5 * deviation / std::sqrt(double(count)) + 1e-12);
        EXPECT_GT(deviation, 0.0);
        EXPECT_LT(deviation, 0.02);
    }
}

/// Estimates of one ray, in the mean, of lamps that are partly hidden.
TEST(AreaLights, SamplesHaveTheirIrradianceAsMean) {
    for (const int cells : {1, 5}) { // 2 and 50 triangles
        const Mesh lamp = test::moved(test::grid(cells, cells, 1.0, 1.0, true), 1.0, Vec3(-0.5, -0.5, 3.0));
        Mesh mesh = test::together(rectangle(-2, 2, -2, 2, 0), lamp);
        mesh = test::together(mesh, rectangle(-10, 0, -10, 10, 1.5));
        std::vector<Index> lamps;
        for (Index t = 0; t < lamp.triangles.size(); ++t) {
            lamps.push_back(2 + t);
        }
        const Scene scene = scene_of(mesh, lamps);
        BruteForceVisibility visibility;
        visibility.build(scene.mesh);
        const AreaLights light(scene, lamps, {scene.mesh, visibility});
        const SurfacePoint x = place_at(mesh, Vec3(0.1, 0.2, 0.0));
        // The screen at half height hides the lamp where it is left of -0.1 as seen from x.
        const Mesh seen = rectangle(-0.1, 0.5, -0.5, 0.5, 3, true);
        const double F = unblocked(seen, {0, 1}, x);
        AreaLights::Worker worker;
        RandomStream stream(1, "samples");
        const int count = 20000;
        double mean = 0.0, squares = 0.0;
        for (int i = 0; i < count; ++i) {
            const AreaLights::Sample sample = light.sample(
                x, {stream.uniform(), stream.uniform(), stream.uniform(), stream.uniform(), stream.uniform()}, worker);
            const Rgb& H = sample.H;
            EXPECT_TRUE((H == 0.0).all() || sample.material == 1);
            EXPECT_DOUBLE_EQ(H[1], 2.0 * H[0]);
            EXPECT_DOUBLE_EQ(H[2], 3.0 * H[0]);
            mean += H[0] / count;
            squares += H[0] * H[0] / count;
        }
        EXPECT_NEAR(mean, F, 4.5 * std::sqrt((squares - mean * mean) / count)) << cells;
        EXPECT_LT(squares, 2.5 * F * F); // the sample varies mostly by being hidden or not (3/5 are seen)
    }
}

/// A lamp 2 long and 0.2 wide at a distance of 0.2, of which a plate half as far away hides a part: its ends send far
/// less than its middle.
TEST(AreaLights, SamplesOfALampNearbyAreUnbiased) {
    const Mesh mesh = test::together(test::together(rectangle(-2, 2, -2, 2, 0), rectangle(-1, 1, -0.1, 0.1, 0.2, true)),
                                     rectangle(-3, 0, -1, 1, 0.1));
    const Scene scene = scene_of(mesh, {2, 3});
    BruteForceVisibility visibility;
    visibility.build(scene.mesh);
    const AreaLights light(scene, {2, 3}, {scene.mesh, visibility});
    for (const double at : {0.1, 0.3}) {
        const SurfacePoint x = place_at(mesh, Vec3(at, 0.03, 0.0));
        const double F = unblocked(rectangle(-at, 1, -0.1, 0.1, 0.2, true), {0, 1}, x); // the plate ends at 0, half way
        AreaLights::Worker worker;
        RandomStream stream(1, "samples");
        const int count = 40000;
        double mean = 0.0, squares = 0.0;
        for (int i = 0; i < count; ++i) {
            const double H =
                light
                    .sample(x,
                            {stream.uniform(), stream.uniform(), stream.uniform(), stream.uniform(), stream.uniform()},
                            worker)
                    .H[0];
            mean += H / count;
            squares += H * H / count;
        }
        EXPECT_NEAR(mean, F, 4.5 * std::sqrt((squares - mean * mean) / count)) << at;
        EXPECT_LT(std::sqrt(squares / count), 0.01 * F) << "else nothing is shown";
    }
}

std::vector<Index> lamp_triangles(const Scene& scene) {
    const std::vector<char> lamps = area_light_materials(scene);
    std::vector<Index> triangles;
    for (Index t = 0; t < scene.mesh.triangles.size(); ++t) {
        if (lamps[scene.mesh.material[t]] != 0) {
            triangles.push_back(t);
        }
    }
    return triangles;
}

/// A row of `cells` unit squares of two triangles each, the first `bright` of them emitting, `materials` in turn.
std::vector<Index> chosen(int cells, int bright, int materials = 1) {
    Scene scene;
    scene.mesh = test::grid(cells, 1, cells, 1.0);
    scene.materials.resize(static_cast<std::size_t>(materials) + 1);
    for (int m = 1; m <= materials; ++m) {
        scene.materials[static_cast<std::size_t>(m)].emission = Rgb(0, 0, 1);
    }
    for (int cell = 0; cell < bright; ++cell) {
        const auto material = static_cast<Index>(1 + cell % materials);
        scene.mesh.material[static_cast<std::size_t>(2 * cell)] = material;
        scene.mesh.material[static_cast<std::size_t>(2 * cell) + 1] = material;
    }
    return lamp_triangles(scene);
}

TEST(AreaLights, WhichTrianglesAreLamps) {
    EXPECT_EQ(chosen(100, 2), (std::vector<Index>{0, 1, 2, 3}));
    EXPECT_TRUE(chosen(100, 0).empty());
    EXPECT_EQ(chosen(100, 9).size(), 18U); // at most a tenth of the surface
    EXPECT_TRUE(chosen(100, 11).empty());
    EXPECT_EQ(chosen(24000, 2049).size(), 4098U); // however many
    EXPECT_EQ(chosen(400, 33, 33).size(), 66U);
    EXPECT_EQ(chosen(100, 13, 2).size(), 12U); // of 7 and 6 squares the smaller, since both would be too large
    EXPECT_EQ(chosen(100, 20, 3).size(), 12U); // of 7, 7 and 6 squares: 1 beside 14/94
    EXPECT_TRUE(chosen(100, 60, 10).empty());  // 6 squares a material: 1 beside 54/94
}

TEST(AreaLights, WhatEmitsUnevenlyIsNoLamp) {
    Scene scene;
    scene.mesh = test::grid(100, 1, 100, 1.0);
    scene.materials.resize(2);
    scene.materials[1].emission = Rgb::Ones();
    scene.mesh.material[0] = 1;
    EXPECT_EQ(lamp_triangles(scene).size(), 1U);
    scene.materials[1].emission_pattern = [](const Vec3& x) { return x.x(); };
    EXPECT_TRUE(lamp_triangles(scene).empty());
    scene.materials.push_back(Material{});
    scene.materials[2].emission = Rgb::Ones();
    scene.mesh.material[7] = 2;
    EXPECT_EQ(lamp_triangles(scene), (std::vector<Index>{7})); // whatever the others do
}

TEST(AreaLights, APatternIsFiniteAndNotNegative) {
    Scene scene;
    scene.mesh = test::grid(1, 1, 1, 1.0);
    scene.materials.resize(1);
    scene.materials[0].emission = Rgb::Ones();
    const SurfacePoint x = scene.mesh.at(0, 0.25, 0.5);
    for (const double factor :
         {-1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 0.5}) {
        scene.materials[0].emission_pattern = [=](const Vec3&) { return factor; };
        if (factor == 0.5) {
            EXPECT_EQ(scene.emission(x)[0], factor);
        } else {
            EXPECT_THROW(scene.emission(x), InputError) << factor;
        }
    }
}

} // namespace
} // namespace difusa::area_lights_test
