// Mirrors: light seen in them, against images, symmetric scenes and the furnace.
#include <difusa/algebra/hit_lists.h>
#include <difusa/bake/light_change.h>
#include <difusa/bake/relight.h>
#include <difusa/core/random.h>
#include <difusa/import/shapes.h>
#include <difusa/lighting/direct_light.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/rays/lambert.h>
#include <difusa/transport/mirrored.h>

#include <support/discretised.h>
#include <support/furnace.h>
#include <support/lit_scenes.h>
#include <support/plugins.h>
#include <support/saved_bakes.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

namespace difusa::mirrors_test {
namespace {

constexpr double pi = std::numbers::pi;

Material material(const std::string& name, const Rgb& rho, const Rgb& mirror, double E = 0.0) {
    Material made;
    made.name = name;
    made.reflectance = rho;
    made.mirror = mirror;
    made.emission = Rgb::Constant(E);
    return made;
}

const Rgb dark = Rgb::Zero(), bright = Rgb::Ones();

/// Direct light at a point, from everything.
Rgb light_at(Scene& scene, const SurfacePoint& x, std::size_t depth = 32) {
    settle_mirrors(scene, depth);
    const auto engine = test::plugin<Visibility>("cgal");
    engine->build(scene.mesh);
    const DirectLight light(scene, Tracer(scene.mesh, *engine));
    DirectLight::Worker worker;
    RandomStream stream(1, "light");
    return light.irradiance(x, 64, stream, worker);
}

/// A floor, material 0, and mirrors that stand on it at x = 0 and, if `second` is not 0, around the z axis at that
/// angle from it; material 1. Everything is large.
Scene wedge(double second, const Rgb& mirror) {
    constexpr double size = 400.0;
    Scene scene;
    scene.mesh = rectangle(Vec3(-size, -size, 0), Vec3(2 * size, 0, 0), Vec3(0, 2 * size, 0));
    // The wedge between the plane y = 0 (above it) and the one at the angle `second`.
    add(scene.mesh, rectangle(Vec3(0, 0, 0), Vec3(0, 0, size), Vec3(size, 0, 0)), 1);
    if (second > 0.0) {
        const Vec3 along(std::cos(second), std::sin(second), 0.0);
        add(scene.mesh, rectangle(Vec3(0, 0, 0), size * along, Vec3(0, 0, size)), 1);
    }
    scene.materials = {material("floor", Rgb::Constant(0.5), dark), material("mirror", dark, mirror)};
    return scene;
}

/// Irradiance of the floor at x from a point light of intensity 1.
double from_point(const Vec3& light, const Vec3& x) {
    const Vec3 way = light - x;
    return way.z() / std::pow(way.norm(), 3);
}

Vec3 turned(const Vec3& p, double angle) {
    return Eigen::AngleAxisd(angle, Vec3::UnitZ()) * p;
}

TEST(Mirrors, APointLightHasAnImage) {
    Scene scene = wedge(0.0, Rgb(0.9, 0.5, 0.1));
    PointLight light;
    light.position = Vec3(1, 2, 1.5);
    light.intensity = bright;
    scene.point_lights.push_back(light);
    const SurfacePoint x{Vec3(2, 1, 0.01), Vec3::UnitZ(), none, 0.0, 0.0};
    const Vec3 image(1, -2, 1.5);
    const Rgb H = light_at(scene, x);
    for (int c = 0; c < 3; ++c) {
        const double expected =
            from_point(light.position, x.position) + scene.materials[1].mirror[c] * from_point(image, x.position);
        EXPECT_NEAR(H[c], expected, 1e-12 * expected);
    }
}

/// Kaleidoscopes: between mirrors at an angle of pi / n, a light has 2n - 1 images.
TEST(Mirrors, TwoPlanesShowAsManyImagesAsTheirAngleAllows) {
    for (const int n : {2, 3, 4}) {
        SCOPED_TRACE(n);
        const double angle = pi / n, m = 0.8;
        RandomStream random(7, "places", static_cast<std::uint64_t>(n));
        for (int i = 0; i < 20; ++i) {
            Scene scene = wedge(angle, Rgb::Constant(m));
            const auto place = [&](double height) {
                return turned(Vec3(1.0 + 2.0 * random.uniform(), 0, height), angle * (0.05 + 0.9 * random.uniform()));
            };
            PointLight light;
            light.position = place(1.0);
            light.intensity = bright;
            scene.point_lights.push_back(light);
            const SurfacePoint x{place(0.01), Vec3::UnitZ(), none, 0.0, 0.0};
            // Chains of k mirrors begin at either plane. The two of n mirrors lead to the same image, and each point
            // sees it over one of them.
            double expected = from_point(light.position, x.position);
            for (const bool first : {false, true}) {
                Vec3 image = light.position;
                bool plane = first;
                for (int k = 1; k <= n - (first ? 1 : 0); ++k, plane = !plane) {
                    const double at = plane ? angle : 0.0;
                    const Vec3 flat = turned(image, -at);
                    image = turned(Vec3(flat.x(), -flat.y(), flat.z()), at);
                    expected += std::pow(m, k) * from_point(image, x.position);
                }
            }
            const Rgb H = light_at(scene, x);
            EXPECT_NEAR(H[0], expected, 1e-9 * expected)
                << x.position.transpose() << ", " << light.position.transpose();
        }
    }
}

TEST(Mirrors, ParallelPlanesShowAnEndlessRow) {
    constexpr double size = 4000.0, m = 0.7, width = 2.0;
    for (const std::size_t depth : {1U, 2U, 7U}) {
        SCOPED_TRACE(depth);
        Scene scene;
        scene.mesh = rectangle(Vec3(0, -size, 0), Vec3(width, 0, 0), Vec3(0, 2 * size, 0));
        add(scene.mesh, rectangle(Vec3(0, -size, 0), Vec3(0, 2 * size, 0), Vec3(0, 0, size)), 1);
        add(scene.mesh, rectangle(Vec3(width, -size, 0), Vec3(0, 0, size), Vec3(0, 2 * size, 0)), 1);
        scene.materials = {material("floor", Rgb::Constant(0.5), dark), material("mirror", dark, Rgb::Constant(m))};
        PointLight light;
        light.position = Vec3(0.6, 0.3, 1.0);
        light.intensity = bright;
        scene.point_lights.push_back(light);
        const SurfacePoint x{Vec3(1.5, 0.0, 0.01), Vec3::UnitZ(), none, 0.0, 0.0};
        double expected = from_point(light.position, x.position);
        for (const bool first_left : {false, true}) {
            Vec3 image = light.position;
            bool left = first_left;
            for (std::size_t k = 1; k <= depth; ++k, left = !left) {
                image.x() = left ? -image.x() : 2.0 * width - image.x();
                expected += std::pow(m, static_cast<double>(k)) * from_point(image, x.position);
            }
        }
        EXPECT_NEAR(light_at(scene, x, depth)[0], expected, 1e-10 * expected);
    }
}

TEST(Mirrors, TheSunShinesOnTheCeiling) {
    Scene scene;
    constexpr double size = 4.0;
    scene.mesh = rectangle(Vec3(0, 0, 2), Vec3(0, size, 0), Vec3(size, 0, 0)); // ceiling, facing down
    add(scene.mesh, rectangle(Vec3(1, 1, 0), Vec3(0.5, 0, 0), Vec3(0, 0.5, 0)), 1);
    scene.materials = {material("ceiling", Rgb::Constant(0.5), dark), material("mirror", dark, Rgb(1.0, 0.5, 0.25))};
    Sun sun;
    sun.towards = Vec3(-1, 0, 0.5).normalized(); // passes under the ceiling
    sun.irradiance = Rgb::Constant(10.0);
    scene.suns.push_back(sun);
    // The patch of light is the mirror, shifted along the reflected sun by the height of the room.
    const Vec3 shift(4.0, 0, 0);
    for (const double u : {-0.01, 0.01, 0.25, 0.49, 0.51}) {
        const SurfacePoint x{Vec3(1 + u, 1.25, 2) + shift, -Vec3::UnitZ(), none, 0.0, 0.0};
        const Rgb H = light_at(scene, x);
        const bool lit = u > 0.0 && u < 0.5;
        const double cosine = sun.towards.z();
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(H[c], lit ? 10.0 * cosine * scene.materials[1].mirror[c] : 0.0, 1e-12) << u;
        }
    }
}

/// In the penumbra around the image of a sun, paths to places on its disc tell their own noise.
TEST(Mirrors, TheNoiseOfThePathsToASunIsTold) {
    Scene scene;
    scene.mesh = rectangle(Vec3(0, 0, 2), Vec3(0, 8, 0), Vec3(8, 0, 0)); // ceiling, facing down
    add(scene.mesh, rectangle(Vec3(1, 1, 0), Vec3(0.5, 0, 0), Vec3(0, 0.5, 0)), 1);
    scene.materials = {material("ceiling", Rgb::Constant(0.5), dark), material("mirror", dark, Rgb(1.0, 0.5, 0.25))};
    Sun sun;
    sun.towards = Vec3(-1, 0, 0.5).normalized();
    sun.irradiance = Rgb::Constant(10.0);
    sun.disc = 0.05;
    scene.suns.push_back(sun);
    settle_mirrors(scene, 32);
    const auto engine = test::plugin<Visibility>("cgal");
    engine->build(scene.mesh);
    const DirectLight light(scene, Tracer(scene.mesh, *engine));
    DirectLight::Worker worker;
    const SurfacePoint x{Vec3(5, 1.25, 2), -Vec3::UnitZ(), none, 0.0, 0.0}; // at the edge of the patch of light
    constexpr int count = 2000;
    Rgb sum = Rgb::Zero(), squares = Rgb::Zero(), told = Rgb::Zero();
    for (int i = 0; i < count; ++i) {
        RandomStream stream(1, "sun", static_cast<std::uint64_t>(i));
        const Rgb H = light.irradiance(x, 64, stream, worker);
        sum += H;
        squares += H * H;
        told += worker.variance / count;
    }
    const Rgb variance = (squares - sum * sum / count) / (count - 1);
    for (int c = 0; c < 3; ++c) {
        // Unbiased; a variance from four batches has a relative standard error of about sqrt(2/3), that of the mean of
        // 2000 of them 1/50, and that of the sample variance 1/30: 4.5 times the two.
        EXPECT_GT(variance[c], 0.0);
        EXPECT_NEAR(told[c] / variance[c], 1.0, 0.2);
    }
}

/// Two mirrors at 45° carry the light of a lamp over a wall: what arrives is that of the lamp at the end of the
/// unfolded way, seen through the mirrors.
TEST(Mirrors, APeriscope) {
    Scene scene;
    // Up from the lamp at the bottom, along x above the wall, and down again to the place x.
    scene.mesh = rectangle(Vec3(-1, -1, 1), Vec3(0, 2, 0), Vec3(2, 0, 2)); // at x = 0, z = 2: faces -x and down ...
    for (Index t = 0; t < scene.mesh.triangles.size(); ++t) {
        scene.mesh.material[t] = 1;
    }
    const auto faces = [&](const Vec3& n) { return scene.mesh.normals.front().dot(n) > 0.0; };
    if (!faces(Vec3(1, 0, -1))) { // ... which must be +x and down
        for (Index t = 0; t < scene.mesh.triangles.size(); ++t) {
            scene.mesh.turn_over(t);
        }
        scene.mesh.derive();
    }
    Mesh other = rectangle(Vec3(4, -1, 3), Vec3(2, 0, -2), Vec3(0, 2, 0)); // at x = 5, z = 2: faces -x and down
    if (other.normals.front().dot(Vec3(-1, 0, -1)) < 0.0) {
        for (Index t = 0; t < other.triangles.size(); ++t) {
            other.turn_over(t);
        }
        other.derive();
    }
    add(scene.mesh, other, 1);
    add(scene.mesh, lit::plain_box(Vec3(2, -5, -5), Vec3(3, 5, 1.2), 1, Front::outside), 0); // hides the lamp itself
    scene.materials = {material("wall", dark, dark), material("mirror", dark, Rgb(0.9, 0.8, 0.5))};
    PointLight light;
    light.position = Vec3(0.05, 0.1, 0);
    light.intensity = Rgb::Constant(100.0);
    scene.point_lights.push_back(light);
    const SurfacePoint x{Vec3(4.9, 0, 0.2), Vec3::UnitZ(), none, 0.0, 0.0};
    // (x, y, z) -> (z - 2, y, x + 2) in the plane x = z - 2, then -> (7 - z, y, 7 - x) in the plane x + z = 7.
    const Vec3& p = light.position;
    const Vec3 first(p.z() - 2.0, p.y(), p.x() + 2.0);
    const Vec3 image(7.0 - first.z(), first.y(), 7.0 - first.x());
    const double arrives = 100.0 * from_point(image, x.position);
    ASSERT_GT(arrives, 0.0);
    const Rgb H = light_at(scene, x);
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(H[c], std::pow(scene.materials[1].mirror[c], 2) * arrives, 1e-10 * arrives);
    }
}

TEST(Mirrors, ShowNothingFromBehindOrWhatIsHidden) {
    const auto lit = [](double mirror_side, bool lid) {
        Scene scene;
        scene.mesh = rectangle(Vec3(-1, -1, 0), Vec3(2, 0, 0), Vec3(0, 2, 0));
        // Above the floor, facing down or up.
        add(scene.mesh,
            mirror_side < 0.0 ? rectangle(Vec3(-3, -3, 3), Vec3(0, 6, 0), Vec3(6, 0, 0))
                              : rectangle(Vec3(-3, -3, 3), Vec3(6, 0, 0), Vec3(0, 6, 0)),
            1);
        add(scene.mesh, rectangle(Vec3(1.1, -0.2, 0.5), Vec3(0, 0.4, 0), Vec3(0.5, 0, 0)), 0); // hides the lamp
        if (lid) {
            add(scene.mesh, rectangle(Vec3(1.2, -0.2, 1.5), Vec3(0, 0.4, 0), Vec3(0.4, 0, 0)), 0); // and its image
        }
        scene.materials = {material("floor", Rgb::Constant(0.5), dark), material("mirror", dark, bright)};
        PointLight light;
        light.position = Vec3(1.4, 0, 1);
        light.intensity = bright;
        scene.point_lights.push_back(light);
        return light_at(scene, {Vec3(1, 0, 0.01), Vec3::UnitZ(), none, 0.0, 0.0})[0];
    };
    const Vec3 x(1, 0, 0.01);
    const double direct = from_point(Vec3(1.4, 0, 1), x), reflected = from_point(Vec3(1.4, 0, 5), x);
    EXPECT_NEAR(lit(-1.0, false), reflected, 1e-12);
    EXPECT_EQ(lit(1.0, false), 0.0) << "from behind";
    EXPECT_EQ(lit(-1.0, true), 0.0) << "hidden";
    EXPECT_GT(direct, 0.0);
}

/// An area light in a large mirror sends what its image would, by Lambert's formula.
TEST(Mirrors, AnAreaLightHasAnImage) {
    Scene scene = wedge(pi / 2, Rgb::Constant(0.6));
    add(scene.mesh, rectangle(Vec3(1, 1, 2), Vec3(0, 0.5, 0), Vec3(0.5, 0, 0)), 2); // faces down
    scene.materials.push_back(material("lamp", dark, dark, 5.0));
    const SurfacePoint x{Vec3(2, 1.5, 0.01), Vec3::UnitZ(), none, 0.0, 0.0};
    const auto F = [&](const Vec3& low) {
        const Vec3 a = low, b = low + Vec3(0, 0.5, 0), c = low + Vec3(0.5, 0.5, 0), d = low + Vec3(0.5, 0, 0);
        return lambert_form_factor(x.position, x.normal, a, b, c) + lambert_form_factor(x.position, x.normal, a, c, d);
    };
    const double expected =
        5.0 * (F(Vec3(1, 1, 2)) + 0.6 * (F(Vec3(-1.5, 1, 2)) + F(Vec3(1, -1.5, 2))) + 0.36 * F(Vec3(-1.5, -1.5, 2)));
    // The shares of samples that get through are exactly 1; the choice among colours is not needed.
    EXPECT_NEAR(light_at(scene, x)[0], expected, 1e-9 * expected);
}

/// Of two lamps above a floor beside a mirror, the bright one is hidden, and so is its image: the dim one's is as
/// bright as it would be alone.
TEST(Mirrors, DimImagesAreNotHiddenByBrightOnes) {
    const auto lit = [](double bright_lamp, const Vec3& place) {
        Scene scene = wedge(0.0, Rgb::Constant(0.6));
        add(scene.mesh, rectangle(Vec3(-1, 3, 2), Vec3(0, 0.5, 0), Vec3(0.5, 0, 0)), 2); // faces down
        scene.materials.push_back(material("dim", dark, dark, 1.0));
        for (int i = 0; i < 8; ++i) {
            for (int j = 0; j < 8; ++j) {
                const Vec3 low(0.1 * i, 1.0 + 0.1 * j, 2.0);
                add(scene.mesh, rectangle(low, Vec3(0, 0.1, 0), Vec3(0.1, 0, 0)), 3);
            }
        }
        add(scene.mesh, rectangle(Vec3(-0.1, 0.9, 1.99), Vec3(0, 1, 0), Vec3(1, 0, 0)), 0); // the plate below them
        scene.materials.push_back(material("bright", dark, dark, bright_lamp));
        return light_at(scene, {place, Vec3::UnitZ(), none, 0.0, 0.0})[0];
    };
    for (int i = 0; i < 16; ++i) {
        const Vec3 place(-1.0 + 0.15 * i, 2.0, 0.01);
        const double alone = lit(0.0, place);
        EXPECT_GT(alone, 0.001);
        EXPECT_NEAR(lit(1000.0, place), alone, 1e-9 * alone);
    }
}

/// Through a small mirror only part of the image is seen; the naive twin tests each place of the lamp.
TEST(Mirrors, AnAreaLightIsSeenThroughTheOutline) {
    Scene scene;
    scene.mesh = rectangle(Vec3(-3, -3, 0), Vec3(6, 0, 0), Vec3(0, 6, 0));
    const Vec3 low(0, 1, 0.5), high(0, 2, 1.5);
    add(scene.mesh, rectangle(low, Vec3(0, 1, 0), Vec3(0, 0, 1)), 1); // faces +x
    const Vec3 corner(1.5, 1.0, 2.0);
    add(scene.mesh, rectangle(corner, Vec3(0, 2, 0), Vec3(1, 0, 0)), 2); // faces down
    scene.materials = {material("floor", Rgb::Constant(0.5), dark), material("mirror", dark, bright),
                       material("lamp", dark, dark, 1.0)};
    const SurfacePoint x{Vec3(0.7, 1.2, 0.01), Vec3::UnitZ(), none, 0.0, 0.0};
    const double without = [&] {
        Scene blind = scene;
        blind.materials[1].mirror = dark;
        return light_at(blind, x)[0];
    }();
    constexpr int n = 1500;
    double expected = 0.0;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            const Vec3 y = corner + Vec3((i + 0.5) / n, 2.0 * (j + 0.5) / n, 0.0);
            const Vec3 way = Vec3(-y.x(), y.y(), y.z()) - x.position;
            const Vec3 at = x.position - x.position.x() / way.x() * way;
            const bool seen = at.y() > low.y() && at.y() < high.y() && at.z() > low.z() && at.z() < high.z();
            expected += seen ? 2.0 * way.z() * way.z() / (pi * std::pow(way.squaredNorm(), 2)) / (n * n) : 0.0;
        }
    }
    ASSERT_GT(expected, 0.001);
    // The sum misses or doubles at most the cells that the outline of the mirror crosses: 4 sides, n cells each, and
    // the kernel varies by less than a factor of 3.
    EXPECT_NEAR(light_at(scene, x)[0] - without, expected, 3.0 * 4.0 / n * expected);
}

/// Where all surfaces reflect the share rho diffusely and m specularly, and emit E, the irradiance after at most d
/// reflections in a row is H = b s with s = 1 + m + ... + m^d and b = E + rho H, in all places.
TEST(Mirrors, FurnaceOfPartialMirrors) {
    for (const std::size_t depth : {1U, 4U}) {
        SCOPED_TRACE(depth);
        const Rgb rho(0.3, 0.4, 0.1), m(0.5, 0.2, 0.9);
        constexpr double E = 2.0;
        Scene scene = test::furnace(0.0, E);
        for (Material& each : scene.materials) {
            each.reflectance = rho;
            each.mirror = m;
        }
        BakeOptions options = lit::quick(0.3, 64);
        options.mirror_depth = depth;
        options.solve.tolerance = 1e-12;
        const BakeResult result = test::baked(scene, options);
        const std::vector<SurfacePoint> x = even_points(result.scene->mesh, 50, RandomStream(3, "points"));
        for (const std::size_t gather : {0U, 64U}) {
            const PointValues values = result.field().at(x, gather, 5, "here", Execution{});
            for (int c = 0; c < 3; ++c) {
                const double s = (1.0 - std::pow(m[c], static_cast<double>(depth + 1))) / (1.0 - m[c]);
                const double H = E * s / (1.0 - rho[c] * s);
                EXPECT_LT((values.H.col(c).array() - H).abs().maxCoeff(), 1e-9 * H) << "channel " << c;
            }
        }
        for (const std::string& note : result.journal.notes()) {
            // A red wall in a blue mirror is dark: no channel's bounces grow, though the largest of each would.
            EXPECT_EQ(note.find("die out"), std::string::npos) << note;
        }
        EXPECT_LT(result.solution.energy.imbalance.abs().maxCoeff(), 1e-9);
        EXPECT_GT(result.solution.energy.cut_off.minCoeff(), 0.0);
    }
}

/// What is cut off counts as error. In the furnace above the share c = m^(d+1) of the light is, and the estimate takes
/// it to be as bright as H / (1 - c), so that e = rho c H / (1 - c) / (1 - rho s); the exact error of B is rho (H' - H)
/// with H' = E / (1 - m - rho), which is larger by the factor 1 + rho c / (1 - m - rho).
TEST(Mirrors, LightThatIsCutOffCountsAsError) {
    for (const std::size_t depth : {1U, 3U, 6U}) {
        SCOPED_TRACE(depth);
        constexpr double rho = 0.3, m = 0.4, E = 2.0;
        Scene scene = test::furnace(0.0, E);
        for (Material& each : scene.materials) {
            each.reflectance = Rgb::Constant(rho);
            each.mirror = Rgb::Constant(m);
        }
        BakeOptions options = lit::quick(0.3, 64);
        options.mirror_depth = depth;
        options.error_points.reset();
        const BakeResult result = test::baked(scene, options);
        const double cut_off = std::pow(m, static_cast<double>(depth + 1)), s = (1.0 - cut_off) / (1.0 - m),
                     H = E * s / (1.0 - rho * s), exact = rho * (E / (1.0 - m - rho) - H),
                     stated = rho * cut_off * H / (1.0 - cut_off) / (1.0 - rho * s);
        ASSERT_TRUE(result.error.has_value());
        // Bounces are followed up to a residual of 5 %, from points that are spread at random: their number says that
        // they are known to some 5 %, too.
        EXPECT_NEAR(result.error->total.rms / stated, 1.0, 0.2);
        EXPECT_NEAR(exact / stated, 1.0 + rho * cut_off / (1.0 - m - rho), 1e-9);
        EXPECT_GE(result.error->total.high, 0.8 * stated);
        const ErrorsAt map =
            ErrorMap(result.solution, *result.error, Execution{}).at(result.error->at.place, Execution{});
        EXPECT_NEAR(map.error.mean() / stated, 1.0, 0.2);
        EXPECT_NEAR(map.irradiance.mean() / (stated / rho), 1.0, 0.2);
    }
}

/// In a convex room with one perfect mirror every ray ends on another wall.
TEST(Mirrors, RowsOfAPerfectMirrorSumToOne) {
    Scene scene = test::furnace(0.5, 1.0);
    scene.materials[0].reflectance = dark;
    scene.materials[0].mirror = bright;
    settle_mirrors(scene, 32);
    const test::Discretised made(scene, 0.3, "cgal", "normalized-radial");
    const LightTransport transport = made.gathered(128);
    EXPECT_EQ(transport.cut_off.maxCoeff(), 0.0);
    Values b = made.on_surfels(1.0);
    std::vector<Surfels::Piece> pieces;
    for (Index s = 0; s < made.discretisation.surfels->size(); ++s) {
        made.discretisation.surfels->pieces(s, pieces);
        b(s, 0) = made.scene.mesh.material[pieces.front().triangle] == 0 ? 0.0 : 1.0;
    }
    const Values sums = test::Discretised::gather(transport, b);
    EXPECT_NEAR(sums.minCoeff(), 1.0, 1e-12);
    EXPECT_NEAR(sums.maxCoeff(), 1.0, 1e-12);
}

/// Between perfect mirrors that face each other light never dies: it is cut off, and accounted for.
TEST(Mirrors, AHallOfMirrorsEnds) {
    Scene scene = test::furnace(0.5, 1.0);
    for (const std::size_t side : {0U, 1U, 2U, 3U, 4U, 5U}) {
        scene.materials[side].reflectance = dark;
        scene.materials[side].mirror = bright;
    }
    settle_mirrors(scene, 5);
    const test::Discretised made(scene, 0.5, "cgal", "normalized-radial");
    const LightTransport transport = made.gathered(32);
    EXPECT_NEAR(transport.cut_off.minCoeff(), 1.0, 1e-12);
    EXPECT_NEAR(transport.cut_off.maxCoeff(), 1.0, 1e-12);
}

/// A room whose left half is its right half's mirror image, and the right half, closed by a mirror.
Scene symmetric_room(bool whole) {
    const double left = whole ? -1.0 : 0.0;
    Scene scene;
    Mesh room = lit::plain_box(Vec3(left, 0, 0), Vec3(1, 1, 1), 1, Front::inside);
    for (Index t = 0; t < room.triangles.size(); ++t) {
        const Vec3 n = room.normals[t];
        room.material[t] = !whole && n.x() > 0.9 ? 1 : n.z() > 0.9 ? 2 : 0;
    }
    scene.mesh = room;
    for (const double side : whole ? std::vector<double>{-1.0, 1.0} : std::vector<double>{1.0}) {
        add(scene.mesh,
            lit::plain_box(Vec3(side * 0.5 - 0.1, 0.4, 0), Vec3(side * 0.5 + 0.1, 0.7, 0.5), 1, Front::outside), 0);
        add(scene.mesh, rectangle(Vec3(side * 0.6 - 0.15, 0.2, 0.95), Vec3(0, 0.3, 0), Vec3(0.3, 0, 0)), 3);
    }
    scene.materials = {material("walls", Rgb(0.6, 0.5, 0.4), dark), material("mirror", dark, bright),
                       material("floor", Rgb(0.3, 0.4, 0.7), dark), material("lamp", dark, dark, 20.0)};
    return scene;
}

TEST(Mirrors, HalfASceneIsTheWholeScene) {
    BakeOptions options;
    options.rays = 256;
    options.error_points = 256;
    const auto bake_of = [&](bool whole) {
        options.sites = whole ? 3000 : 1500;
        return test::baked(symmetric_room(whole), options);
    };
    const BakeResult whole = bake_of(true), half = bake_of(false);
    EXPECT_GT(half.system->transport().cut_off.rows(), 0);
    std::vector<SurfacePoint> in_half, in_whole;
    for (const SurfacePoint& x : even_points(half.scene->mesh, 500, RandomStream(3, "points"))) {
        if (half.scene->mesh.material[x.face] != 1) {
            in_half.push_back(x);
        }
    }
    const auto engine = test::plugin<Visibility>("cgal");
    engine->build(whole.scene->mesh);
    for (const SurfacePoint& x : in_half) { // the same place, found from just above it
        const Ray ray{x.position + 1e-6 * x.normal, -x.normal, none};
        Hit hit;
        engine->first_hits({&ray, 1}, {&hit, 1});
        ASSERT_NE(hit.face, none);
        in_whole.push_back(whole.scene->mesh.at(hit.face, hit.u, hit.v));
    }
    const PointValues a = half.field().at(in_half, 0, 5, "here", Execution{});
    const PointValues b = whole.field().at(in_whole, 0, 5, "here", Execution{});
    const double difference = std::sqrt((a.B - b.B).rowwise().squaredNorm().mean());
    // Each lies below with 97.5 %; the bakes share no random numbers that matter.
    EXPECT_LE(difference, half.error->total.high + whole.error->total.high);
    EXPECT_GT(difference, 0.0);
}

TEST(Mirrors, HaveTheSameBitsForAnyNumberOfThreads) {
    Scene scene = symmetric_room(false);
    scene.materials[1].mirror = Rgb(0.9, 0.7, 0.5);
    const auto with = [&](unsigned threads) {
        return bake(test::registry(), scene, "scene", lit::quick(0.25, 64), Execution{threads, nullptr, nullptr});
    };
    const BakeResult one = with(1), three = with(3);
    EXPECT_TRUE((one.solution.h.array() == three.solution.h.array()).all());
    EXPECT_TRUE((one.output.B.array() == three.output.B.array()).all());
    EXPECT_TRUE((one.solution.energy.cut_off == three.solution.energy.cut_off).all());
}

TEST(Mirrors, NoneCostNothing) {
    const test::Discretised made(test::furnace(0.5, 1.0), 0.4, "cgal", "normalized-radial");
    const LightTransport transport = made.gathered(32, "fibonacci");
    EXPECT_NE(dynamic_cast<const HitLists*>(transport.W.get()), nullptr);
    EXPECT_EQ(transport.cut_off.rows(), 0);
    const DirectLight light(made.scene, made.tracer());
    EXPECT_EQ(light.images(), nullptr);
}

TEST(Mirrors, RelitResultsHaveTheBitsOfABake) {
    for (const bool coloured : {false, true}) {
        Scene scene = symmetric_room(false);
        scene.materials[1].mirror = coloured ? Rgb(0.9, 0.7, 0.5) : bright;
        const BakeOptions options = test::relightable("gather", "moving-least-squares");
        const SavedTransport saved = test::through_file(bake(test::registry(), scene, "scene", options, Execution{}));
        scene.materials[0].reflectance = Rgb(0.2, 0.6, 0.8);
        scene.materials[3].emission = Rgb(3.0, 2.0, 5.0);
        test::expect_bits_of_a_bake(saved, scene, options);
        // Mirrors are geometry.
        scene.materials[1].mirror *= 0.5;
        EXPECT_THROW(relight(test::registry(), saved, scene, "scene", test::as_baked(saved), Execution{}), InputError);
    }
}

TEST(Mirrors, RelightingDoesNotMakeThemReflectMoreThanAllLight) {
    Scene scene = symmetric_room(false);
    scene.materials[1].mirror = Rgb::Constant(0.75);
    LightChange change;
    change.reflectance = {{"mirror", Rgb::Constant(0.25)}};
    EXPECT_NO_THROW(change_light(change, scene));
    change.reflectance = {{"mirror", Rgb(0.25, 0.5, 0.0)}};
    EXPECT_THROW(change_light(change, scene), UsageError);
}

TEST(Mirrors, SolversThatNeedRowsRefuseThem) {
    BakeOptions options = lit::quick(0.5);
    options.basis = "normalized-radial";
    options.projection = "natural";
    for (const char* solver : {"gauss-seidel", "southwell", "progressive"}) {
        options.solver = solver;
        EXPECT_THROW(test::baked(symmetric_room(false), options), UsageError) << solver;
    }
}

TEST(Mirrors, PairwiseTransportRefusesColouredOnes) {
    BakeOptions options = lit::quick(0.5);
    options.transport = "pairwise";
    EXPECT_NO_THROW(test::baked(symmetric_room(false), options));
    Scene scene = symmetric_room(false);
    scene.materials[1].mirror = Rgb(0.9, 0.8, 0.7);
    EXPECT_THROW(test::baked(scene, options), UsageError);
}

TEST(Mirrors, ReflectNoMoreThanAllLight) {
    Scene scene = symmetric_room(false);
    scene.materials[1].reflectance = Rgb::Constant(0.1);
    EXPECT_THROW(test::baked(scene, lit::quick(0.5)), InputError);
}

} // namespace
} // namespace difusa::mirrors_test
