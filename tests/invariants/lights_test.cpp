// Lights of every kind against closed forms, and what a scene does not need.
#include <difusa/bake.h>
#include <difusa/import/shapes.h>
#include <difusa/lighting/lambert.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/rays/brute_force.h>
#include <difusa/scene/light_groups.h>
#include <difusa/scene/sky_dome.h>
#include <difusa/transport/gather.h>

#include <support/rooms.h>
#include <support/sited.h>

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>

namespace difusa {
namespace {

constexpr double pi = std::numbers::pi;

Scene scene_of(Mesh mesh, double rho) {
    return test::uniform_scene(std::move(mesh), rho, 0.0);
}

/// The box of lib/import/shapes.h, all of one material.
Mesh plain_box(const Vec3& low, const Vec3& high, int n, Front front) {
    Mesh mesh = box(low, high, n, front);
    mesh.material.assign(mesh.triangles.size(), 0);
    return mesh;
}

BakeOptions quick(double spacing, std::size_t rays = 64) {
    BakeOptions options;
    options.spacing = spacing;
    options.rays = rays;
    options.error_points = 0;
    return options;
}

BakeResult baked(const Scene& scene, const BakeOptions& options) {
    return bake(test::registry(), scene, "scene", options, Execution{});
}

/// The light at points of a surface, as a bake evaluates it.
PointValues at(const Scene& scene, const BakeOptions& options, const std::vector<SurfacePoint>& x) {
    const BakeResult result = baked(scene, options);
    return result.solution.at(x, options.final_gather, 1, "test", Execution{});
}

/// A black floor below a point light: I cos / r².
TEST(PointLights, InverseSquareAndCosine) {
    Scene scene = scene_of(rectangle(Vec3(-2, -2, 0), Vec3(4, 0, 0), Vec3(0, 4, 0)), 0.0);
    scene.point_lights = {{Vec3(0.3, -0.2, 1.5), Rgb(10, 20, 30)}};
    const auto x = even_points(scene.mesh, 500, RandomStream(1, "points"));
    const PointValues values = at(scene, quick(0.5), x);
    for (std::size_t i = 0; i < x.size(); ++i) {
        const Vec3 way = Vec3(0.3, -0.2, 1.5) - x[i].position;
        const double exact = 10.0 * 1.5 / std::pow(way.norm(), 3);
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(values.H(static_cast<Eigen::Index>(i), c), (c + 1) * exact, 1e-14 * (c + 1) * exact);
        }
    }
}

/// In the middle of a black sphere of radius R a point light gives I / R², which takes in all of 4 pi I.
TEST(PointLights, PowerInAClosedSphere) {
    Scene scene = scene_of(sphere(2.0, 3, Front::inside), 0.5);
    scene.point_lights = {{Vec3::Zero(), Rgb::Constant(3.0)}};
    const BakeResult result = baked(scene, quick(0.4));
    // The facets' solid angles sum to 4 pi; what they receive directly is 4 pi I whatever their shape, but sites sample
    // it.
    double received = 0.0;
    for (const SurfacePoint& x : even_points(scene.mesh, 20000, RandomStream(1, "points"))) {
        const Vec3 way = -x.position;
        received += scene.mesh.area / 20000.0 * 3.0 * x.normal.dot(way.normalized()) / way.squaredNorm();
    }
    EXPECT_NEAR(received, 12.0 * pi, 12.0 * pi * 1e-3); // facets: cos / r² varies by less than 2 % over each
    // All light ends absorbed: H = E_direct / (1 - rho) on average.
    EXPECT_NEAR(result.energy.from_lights[0], 12.0 * pi, 12.0 * pi * 0.01);
    EXPECT_LT(std::abs((*result.energy.imbalance)[0]), 1e-2);
    EXPECT_NEAR(result.output.H.col(0).mean(), 2.0 * 3.0 / 4.0, 0.02);
}

TEST(PointLights, ASpotHasTheFalloffOfItsCone) {
    Scene scene = scene_of(rectangle(Vec3(-2, -2, 0), Vec3(4, 0, 0), Vec3(0, 4, 0)), 0.0);
    PointLight spot;
    spot.position = Vec3(0, 0, 2);
    spot.intensity = Rgb::Constant(8.0);
    spot.cos_inner = std::cos(0.2);
    spot.cos_outer = std::cos(0.5);
    scene.point_lights = {spot};
    const auto x = even_points(scene.mesh, 1000, RandomStream(1, "points"));
    const PointValues values = at(scene, quick(0.5), x);
    int inside = 0, between = 0, outside = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        const double r2 = x[i].position.squaredNorm() + 4.0, cosine = 2.0 / std::sqrt(r2);
        const double angle = std::acos(cosine);
        const double part = angle <= 0.2   ? 1.0
                            : angle >= 0.5 ? 0.0
                                           : (cosine - std::cos(0.5)) / (std::cos(0.2) - std::cos(0.5));
        EXPECT_NEAR(values.H(static_cast<Eigen::Index>(i), 0), 8.0 * part * part * cosine / r2, 1e-12);
        (part == 1.0 ? inside : part == 0.0 ? outside : between) += 1;
    }
    EXPECT_GT(inside, 5);
    EXPECT_GT(between, 50);
    EXPECT_GT(outside, 500);
}

TEST(PointLights, AWallCastsItsShadow) {
    Mesh mesh = rectangle(Vec3(-2, -2, 0), Vec3(4, 0, 0), Vec3(0, 4, 0));
    add(mesh, rectangle(Vec3(-0.5, -0.5, 1), Vec3(1, 0, 0), Vec3(0, 1, 0)), 0);
    Scene scene = scene_of(mesh, 0.0);
    scene.point_lights = {{Vec3(0, 0, 2), Rgb::Ones()}};
    const auto x = even_points(mesh, 2000, RandomStream(1, "points"));
    const PointValues values = at(scene, quick(0.5), x);
    for (std::size_t i = 0; i < x.size(); ++i) {
        if (x[i].position.z() == 0.0) {
            const bool shaded = x[i].position.head<2>().cwiseAbs().maxCoeff() < 1.0; // twice the wall's size
            EXPECT_EQ(values.H(static_cast<Eigen::Index>(i), 0) == 0.0, shaded) << x[i].position.transpose();
        }
    }
}

/// The sun through a window: what it lights is the window's image along its rays, with sharp borders.
/// On edges between triangles, where places with round coordinates often are, the light is that of the very place.
TEST(PointLights, OnEdgesToo) {
    Scene scene = scene_of(rectangle(Vec3::Zero(), Vec3(1000, 0, 0), Vec3(0, 1000, 0)), 0.5);
    scene.point_lights = {{Vec3(3, 3, 0.1), Rgb::Ones()}};
    const std::vector<SurfacePoint> x{scene.mesh.at(0, 0.0, 0.003), scene.mesh.at(0, 0.003, 0.0),
                                      scene.mesh.at(1, 0.0, 0.003), scene.mesh.at(1, 0.003, 0.0)};
    const PointValues values = at(scene, quick(100.0, 16), x);
    bool below = false;
    for (std::size_t i = 0; i < x.size(); ++i) {
        const Vec3 way = scene.point_lights[0].position - x[i].position;
        const double exact = 0.1 / std::pow(way.norm(), 3);
        EXPECT_NEAR(values.H_direct(static_cast<Eigen::Index>(i), 0), exact,
                    1e-11 * exact); // rounding of places of 1000, thrice over 0.1
        below = below || way.norm() < 0.2;
    }
    EXPECT_TRUE(below); // one of them is right below the light
}

/// A bulb at the height of the ceiling: rounding must not put it behind.
TEST(PointLights, OnAFaceLightsTheWholeRoom) {
    Scene scene = scene_of(plain_box(Vec3::Zero(), Vec3::Ones(), 16, Front::inside), 0.0);
    scene.point_lights = {{Vec3(0.37, 0.41, 1.0), Rgb::Ones()}};
    for (const std::string& engine : test::plugin_names<Visibility>()) {
        BakeOptions options = quick(0.5, 1);
        options.visibility = engine;
        const BakeResult result = baked(scene, options);
        const Mesh& mesh = result.scene->mesh;
        std::vector<SurfacePoint> x;
        for (Index t = 0; t < mesh.triangles.size(); ++t) {
            x.push_back(mesh.at(t, 1.0 / 3.0, 1.0 / 3.0));
        }
        const PointValues values = result.solution.at(x, 0, 1, "test", Execution{});
        for (std::size_t t = 0; t < x.size(); ++t) {
            const Vec3 way = scene.point_lights[0].position - x[t].position;
            const double exact = x[t].position.z() < 1.0 ? x[t].normal.dot(way) / std::pow(way.norm(), 3) : 0.0;
            EXPECT_NEAR(values.H(static_cast<Eigen::Index>(t), 0), exact, 1e-12 * exact) << engine;
        }
    }
}

TEST(Suns, ThroughAWindow) {
    // A closed room [0,1]³ without its wall x = 1, and before that a wall with a window: four rectangles around it.
    Mesh mesh = box(Vec3::Zero(), Vec3::Ones(), 1, Front::inside);
    std::vector<std::array<Index, 3>> kept;
    std::vector<Index> faces;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        if (mesh.normals[t].x() > -0.5) {
            kept.push_back(mesh.triangles[t]);
            faces.push_back(static_cast<Index>(faces.size()));
        }
    }
    mesh.triangles = kept;
    mesh.original_face = faces;
    mesh.material.assign(kept.size(), 0);
    mesh.derive();
    const double y0 = 0.25, y1 = 0.625, z0 = 0.5, z1 = 0.875;
    const auto piece = [&](double ya, double za, double yb, double zb) { // facing -x
        add(mesh, rectangle(Vec3(1, ya, za), Vec3(0, 0, zb - za), Vec3(0, yb - ya, 0)), 0);
    };
    piece(0, 0, 1, z0);
    piece(0, z1, 1, 1);
    piece(0, z0, y0, z1);
    piece(y1, z0, 1, z1);
    Scene scene = scene_of(mesh, 0.0);
    const Vec3 s = Vec3(1.0, 0.1, 0.7).normalized();
    scene.suns = {{s, Rgb::Constant(1000.0)}};
    const auto x = even_points(mesh, 4000, RandomStream(1, "points"));
    const PointValues values = at(scene, quick(0.2), x);
    int lit = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        const Vec3& p = x[i].position;
        const double cosine = x[i].normal.dot(s), way = (1.0 - p.x()) / s.x();
        const Vec3 there = p + way * s;
        const bool through =
            cosine > 0.0 && p.x() < 1.0 && there.y() > y0 && there.y() < y1 && there.z() > z0 && there.z() < z1;
        EXPECT_DOUBLE_EQ(values.H(static_cast<Eigen::Index>(i), 0), through ? 1000.0 * cosine : 0.0) << p.transpose();
        lit += through ? 1 : 0;
    }
    EXPECT_GT(lit, 100);
}

/// The penumbra of a long lamp behind a straight edge: of the lamp a point sees the part beyond the edge, which is a
/// rectangle again and has a form factor in closed form.
TEST(Penumbra, OfALampBehindAnEdge) {
    const double edge = 0.25; // the screen reaches up to x = edge at half the height
    Mesh mesh = rectangle(Vec3(-2, -2, 0), Vec3(4, 0, 0), Vec3(0, 4, 0));
    add(mesh, rectangle(Vec3(-9, -9, 0.5), Vec3(9 + edge, 0, 0), Vec3(0, 18, 0)), 0);
    add(mesh, rectangle(Vec3(-0.5, -1, 1), Vec3(0, 2, 0), Vec3(1, 0, 0)), 1); // facing down
    Scene scene = scene_of(mesh, 0.0);
    scene.materials.resize(2);
    scene.materials[1].emission = Rgb::Constant(2.0);
    std::vector<SurfacePoint> x;
    for (int i = 0; i < 400; ++i) {
        SurfacePoint p = mesh.at(0, 0.0, 0.0);
        p.position = Vec3(-0.6 + 1.6 * (i + 0.5) / 400, 0.1, 0.0);
        const Vec3 way = p.position - mesh.corner(0, 0); // triangle 0 is below the diagonal
        p.face = way.x() > way.y() ? 0 : 1;
        p.u = p.face == 0 ? (way.x() - way.y()) / 4 : way.x() / 4;
        p.v = p.face == 0 ? way.y() / 4 : (way.y() - way.x()) / 4;
        x.push_back(p);
    }
    const PointValues values = at(scene, quick(0.5), x);
    double squares = 0.0;
    int partly = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        // Seen from x the edge projects to 2 edge - x on the lamp's plane; beyond it the lamp is seen.
        const double from = std::clamp(2.0 * edge - x[i].position.x(), -0.5, 0.5);
        const auto part = [&](double a) {
            const Vec3 p(a, -1, 1), q(a, 1, 1), r(0.5, 1, 1), s(0.5, -1, 1);
            return lambert_form_factor(x[i].position, Vec3::UnitZ(), p, q, r) +
                   lambert_form_factor(x[i].position, Vec3::UnitZ(), p, r, s);
        };
        const double exact = from < 0.5 ? 2.0 * part(from) : 0.0, all = 2.0 * part(-0.5);
        const double H = values.H(static_cast<Eigen::Index>(i), 0);
        if (from == -0.5 || from == 0.5) {
            EXPECT_NEAR(H, exact, 1e-14) << x[i].position.transpose(); // wholly seen, or wholly hidden
        } else {
            // 64 stratified rays at least: not worse than independent ones of 4.5 standard deviations.
            EXPECT_NEAR(H, exact, 4.5 * 0.5 / 8.0 * all);
            squares += std::pow((H - exact) / all, 2);
            ++partly;
        }
    }
    ASSERT_GT(partly, 150);
    // Rounds are repeated until the standard error of their mean is 0.4 %, or there were eight of them: then that of
    // 512 independent rays bounds it, sqrt(1/4 / 512) = 2.2 %; most points settle.
    EXPECT_LT(std::sqrt(squares / partly), 0.011);
}

/// A uniform sky seen through a rectangular hole in the ceiling lights like a lamp of the hole's shape.
TEST(Skies, ThroughAWindowLikeALampOfItsShape) {
    Mesh mesh = rectangle(Vec3(-1, -1, 0), Vec3(2, 0, 0), Vec3(0, 2, 0));
    const double h = 0.3;
    for (const auto& [a, b, c, d] : {std::array{-50.0, -50.0, 50.0, -h}, std::array{-50.0, h, 50.0, 50.0},
                                     std::array{-50.0, -h, -h, h}, std::array{h, -h, 50.0, h}}) {
        add(mesh, rectangle(Vec3(a, b, 1), Vec3(0, d - b, 0), Vec3(c - a, 0, 0)), 0); // facing down
    }
    Scene scene = scene_of(mesh, 0.0);
    scene.sky = Rgb::Constant(pi);
    constexpr std::size_t N = 4096;
    BruteForceVisibility visibility;
    visibility.build(scene.mesh);
    const SiteSet sites = test::poisson_sites(scene.mesh, 40.0);
    const auto basis = test::plugin<Basis>("shepard");
    basis->bind(scene.mesh, sites);
    std::vector<SurfacePoint> x;
    for (const SurfacePoint& p : even_points(mesh, 100000, RandomStream(1, "points"))) {
        if (p.position.z() == 0.0) {
            x.push_back(p);
        }
    }
    ASSERT_GT(x.size(), 20U);
    for (const bool as_dome : {false, true}) {
        if (as_dome) {
            scene.sky = Rgb::Zero();
            scene.dome = std::make_shared<GradientSky>(Rgb::Ones(), Rgb::Ones(), Rgb::Ones(), Vec3::UnitZ());
        }
        const Transport transport =
            gather(scene, x, *basis, visibility, *test::plugin<Directions>("low-discrepancy"), N, 1, Execution{});
        const Values H = direct_irradiance(scene, all_lights(scene), transport, 1, Execution{});
        for (std::size_t i = 0; i < x.size(); ++i) {
            const Vec3 p(-h, -h, 1), q(-h, h, 1), r(h, h, 1), s(h, -h, 1);
            const double F = lambert_form_factor(x[i].position, Vec3::UnitZ(), p, q, r) +
                             lambert_form_factor(x[i].position, Vec3::UnitZ(), p, r, s);
            EXPECT_NEAR(H(static_cast<Eigen::Index>(i), 0), pi * F, 4.5 * pi * std::sqrt(F * (1 - F) / N));
        }
    }
}

/// On level ground a gradient gives pi (horizon + 2 zenith) / 3.
TEST(Skies, AGradientOnLevelGround) {
    Scene scene = scene_of(rectangle(Vec3::Zero(), Vec3(1, 0, 0), Vec3(0, 1, 0)), 0.3);
    scene.dome = std::make_shared<GradientSky>(Rgb(3, 6, 9), Rgb(1, 2, 3), Rgb(100, 100, 100), Vec3::UnitZ());
    const BakeResult result = baked(scene, quick(0.2, 1024));
    for (int c = 0; c < 3; ++c) {
        const double exact = pi * (c + 1) * (1.0 + 2.0 * 3.0) / 3.0;
        // pi times the mean of a radiance whose standard deviation is below half its range of 2 (c + 1).
        const double bound = 4.5 * pi * (c + 1) / std::sqrt(1024.0);
        EXPECT_LT((result.output.H.col(c).array() - exact).abs().maxCoeff(), bound);
        EXPECT_NEAR(result.output.H.col(c).mean(), exact, bound / 5);
    }
}

/// An image of one colour is an even sky, and its directions are those it says.
TEST(Skies, AnImageLooksWhereItSays) {
    Image image{8, 4, std::vector<std::array<float, 3>>(32, {0.5F, 1.0F, 2.0F})};
    const ImageSky even(image, 2.0, Vec3::UnitZ(), Vec3::UnitY());
    for (const Vec3& d : {Vec3(1, 0, 0), Vec3(0, 0, -1), Vec3(0.6, 0, 0.8)}) {
        EXPECT_TRUE(even.radiance(d).isApprox(Rgb(1, 2, 4), 1e-15));
    }
    // One pixel at a time: its centre, in the upper row straight above the horizon's, middle column to the right.
    for (const auto& [column, row] : {std::pair(4, 1), std::pair(6, 1), std::pair(2, 2)}) {
        Image one{8, 4, std::vector<std::array<float, 3>>(32, {0.0F, 0.0F, 0.0F})};
        one.pixels[static_cast<std::size_t>(row * 8 + column)] = {1.0F, 1.0F, 1.0F};
        const ImageSky sky(one, 1.0, Vec3::UnitZ(), Vec3::UnitY());
        const double azimuth = ((column + 0.5) / 8.0 - 0.5) * 2.0 * pi, polar = (row + 0.5) / 4.0 * pi;
        // Who looks along +y with z up has +x on the right.
        const Vec3 there(std::sin(polar) * std::sin(azimuth), std::sin(polar) * std::cos(azimuth), std::cos(polar));
        EXPECT_NEAR(sky.radiance(there)[0], 1.0, 1e-12) << column << ", " << row;
        EXPECT_NEAR(sky.radiance(-there)[0], 0.0, 1e-12);
    }
}

/// A small bright spot becomes a sun; together with what is left the irradiance is that of the image.
TEST(Skies, BrightSpotsBecomeSuns) {
    Image image{64, 32, std::vector<std::array<float, 3>>(64 * 32, {1.0F, 1.0F, 1.0F})};
    image.pixels[10 * 64 + 40] = {5000.0F, 4000.0F, 3000.0F};
    for (std::size_t i = 0; i < 64 * 4; ++i) {
        image.pixels[28 * 64 + i] = {60.0F, 60.0F, 60.0F}; // bright and wide: no sun
    }
    ImageSky sky(image, 1.0, Vec3::UnitZ(), Vec3::UnitY());
    const std::vector<Sun> suns = sky.split_suns(8.0);
    ASSERT_EQ(suns.size(), 1U);
    const double polar = 10.5 / 32 * pi, azimuth = (40.5 / 64 - 0.5) * 2 * pi;
    EXPECT_TRUE(suns[0].towards.isApprox(
        Vec3(std::sin(polar) * std::sin(azimuth), std::sin(polar) * std::cos(azimuth), std::cos(polar)), 1e-12));
    const double solid_angle = 2 * pi / 64 * (std::cos(10 * pi / 32) - std::cos(11 * pi / 32));
    EXPECT_EQ(suns[0].name, "sky");
    const Rgb left = sky.radiance(suns[0].towards);
    EXPECT_TRUE((suns[0].irradiance + solid_angle * left).isApprox(solid_angle * Rgb(5000, 4000, 3000), 1e-6));
    EXPECT_LT(left.mean(), 4000.0 / 10);
    EXPECT_TRUE(sky.split_suns(8.0).empty() || sky.split_suns(8.0)[0].irradiance.mean() < suns[0].irradiance.mean());
}

/// Radiance times solid angle over all pixels of an image sky, and the irradiance of the suns taken out of it.
Rgb total(const ImageSky& sky, const std::vector<Sun>& suns, std::size_t width, std::size_t height) {
    Rgb sum = Rgb::Zero();
    for (std::size_t row = 0; row < height; ++row) {
        const double step = pi / static_cast<double>(height), polar = (static_cast<double>(row) + 0.5) * step;
        const double size = 2 * pi / static_cast<double>(width) * 2.0 * std::sin(polar) * std::sin(0.5 * step);
        for (std::size_t column = 0; column < width; ++column) {
            const double azimuth = ((static_cast<double>(column) + 0.5) / static_cast<double>(width) - 0.5) * 2 * pi;
            sum += size * sky.radiance(Vec3(std::sin(polar) * std::sin(azimuth), std::sin(polar) * std::cos(azimuth),
                                            std::cos(polar)));
        }
    }
    for (const Sun& sun : suns) {
        sum += sun.irradiance;
    }
    return sum;
}

/// Two suns in one wide halo above the limit: each is taken out above the halo, which stays, and no light is lost.
TEST(Skies, SunsInAHaloAreFound) {
    constexpr std::size_t width = 256, height = 128;
    Image image{width, height, std::vector<std::array<float, 3>>(width * height, {1.0F, 1.0F, 1.0F})};
    for (std::size_t row = 24; row < 40; ++row) { // 0.11 sr
        for (std::size_t column = 100; column < 116; ++column) {
            image.pixels[row * width + column] = {40.0F, 40.0F, 40.0F};
        }
    }
    image.pixels[30 * width + 104] = {40000.0F, 30000.0F, 20000.0F};
    image.pixels[33 * width + 112] = {5000.0F, 5000.0F, 5000.0F};
    const ImageSky whole(image, 1.0, Vec3::UnitZ(), Vec3::UnitY());
    ImageSky sky = whole;
    ASSERT_GT(40.0, 8 * whole.mean());
    const std::vector<Sun> suns = sky.split_suns(8.0);
    ASSERT_EQ(suns.size(), 2U);
    for (const auto& [sun, row, column] : {std::tuple(suns[0], 30, 104), std::tuple(suns[1], 33, 112)}) {
        EXPECT_TRUE(sun.of_sky);
        const double polar = (row + 0.5) / height * pi, azimuth = ((column + 0.5) / width - 0.5) * 2 * pi;
        const Vec3 there(std::sin(polar) * std::sin(azimuth), std::sin(polar) * std::cos(azimuth), std::cos(polar));
        EXPECT_LT((sun.towards - there).norm(), 1e-12);
        // What is left is no darker than the halo and at most twice as bright.
        EXPECT_GE(sky.radiance(there).mean(), 40.0);
        EXPECT_LE(sky.radiance(there).mean(), 80.0);
    }
    EXPECT_TRUE(total(sky, suns, width, height).isApprox(total(whole, {}, width, height), 1e-6));
    // The halo is left as it was, and is told.
    const double halo = 16 * 2 * pi / width * (std::cos(24 * pi / height) - std::cos(40 * pi / height));
    EXPECT_NEAR(sky.solid_angle_above(39.0), halo, 1e-12);
    EXPECT_EQ(sky.solid_angle_above(80.0), 0.0);
    // Without the suns nothing in it is small: nothing is taken.
    image.pixels[30 * width + 104] = image.pixels[33 * width + 112] = {40.0F, 40.0F, 40.0F};
    ImageSky wide(image, 1.0, Vec3::UnitZ(), Vec3::UnitY());
    EXPECT_TRUE(wide.split_suns(8.0).empty());
    EXPECT_EQ(wide.mean(), ImageSky(image, 1.0, Vec3::UnitZ(), Vec3::UnitY()).mean());
    // Neither is there a sun in a black sky.
    ImageSky black({8, 4, std::vector<std::array<float, 3>>(32, {0.0F, 0.0F, 0.0F})}, 1.0, Vec3::UnitZ(),
                   Vec3::UnitY());
    EXPECT_TRUE(black.split_suns(8.0).empty());
}

/// A sky on the command line takes the place of the scene's, with the suns taken out of that, but of no others.
TEST(Skies, AnotherSkyTakesThePlaceOfItsSuns) {
    Scene scene = scene_of(rectangle(Vec3::Zero(), Vec3(1, 0, 0), Vec3(0, 1, 0)), 0.0);
    scene.dome = std::make_shared<GradientSky>(Rgb::Ones(), Rgb::Ones(), Rgb::Ones(), Vec3::UnitZ());
    scene.suns = {{Vec3::UnitZ(), Rgb::Constant(5), "sky", true}, {Vec3::UnitZ(), Rgb::Constant(3), "sky"}};
    BakeOptions options = quick(0.3, 1024);
    options.sky = Rgb::Zero();
    EXPECT_LT((baked(scene, options).output.H.array() - 3.0).abs().maxCoeff(), 1e-14 * 3.0);
    scene.suns.pop_back();
    EXPECT_THROW(baked(scene, options), InputError) << "no light is left";
}

/// A room with a lamp, a sun, a point light and a sky: each group is what its lights alone would give, and the groups
/// add up to the whole.
TEST(LightGroups, AddUpToTheWhole) {
    Mesh mesh = rectangle(Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 2, 0));
    add(mesh, rectangle(Vec3(0, 2, 0), Vec3(2, 0, 0), Vec3(0, 0, 2)), 0);
    add(mesh, rectangle(Vec3(0.5, 0.5, 1.5), Vec3(0, 0.2, 0), Vec3(0.2, 0, 0)), 1);
    Scene scene = scene_of(mesh, 0.6);
    scene.materials.resize(2);
    scene.materials[1].name = "lamp";
    scene.materials[1].emission = Rgb(10, 20, 30);
    scene.suns = {{Vec3(0, -1, 2).normalized(), Rgb(3, 2, 1), "noon"}};
    scene.point_lights = {{Vec3(1, 1, 1), Rgb(1, 1, 2)}};
    scene.sky = Rgb(0.5, 0.6, 0.7);
    BakeOptions options = quick(0.3);
    options.light_groups = true;
    const BakeResult whole = baked(scene, options);
    ASSERT_EQ(whole.output.groups.size(), 4U);
    const std::vector<std::string> names{"lamp", "noon", "point", "sky"};
    Values B = Values::Zero(whole.output.B.rows(), 3), H = B;
    for (std::size_t g = 0; g < 4; ++g) {
        EXPECT_EQ(whole.output.groups[g].name, names[g]);
        B += whole.output.groups[g].B;
        H += whole.output.groups[g].H;
        Scene alone = scene;
        if (g != 0) {
            alone.materials[1].emission.setZero();
        }
        if (g != 1) {
            alone.suns.clear();
        }
        if (g != 2) {
            alone.point_lights.clear();
        }
        options.light_groups = false;
        options.sky = g == 3 ? scene.sky : Rgb(Rgb::Zero());
        const BakeResult one = baked(alone, options);
        // The solver stops at a residual of 1e-6 of the light; 1 / (1 - rho) times that is the error.
        const double tolerance = 2.0 * 1e-6 / (1.0 - 0.6) * one.irradiance_direct.maxCoeff();
        ASSERT_EQ(one.output.B.rows(), B.rows());
        EXPECT_LT((one.output.B - whole.output.groups[g].B).cwiseAbs().maxCoeff(), tolerance) << names[g];
    }
    const double rounding = 64 * 0x1p-53 * whole.output.B.maxCoeff();
    EXPECT_LT((B - whole.output.B).cwiseAbs().maxCoeff(), rounding);
    EXPECT_LT((H - whole.output.H).cwiseAbs().maxCoeff(), rounding);
    // And without groups it is the same solution: the solver treats other columns, and lamps draw alike. (Between the
    // sites each light is kept within its own bounds.)
    options.light_groups = false;
    options.sky.reset();
    const BakeResult together = baked(scene, options);
    EXPECT_LT((together.irradiance - whole.irradiance).cwiseAbs().maxCoeff(),
              2.0 * 1e-6 / (1.0 - 0.6) * together.irradiance_direct.maxCoeff());
}

TEST(LightGroups, NamesAndOrder) {
    Scene scene = scene_of(rectangle(Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 2, 0), 2, 2), 0.5);
    scene.materials.resize(3);
    scene.materials[1] = {"a", Rgb::Zero(), Rgb::Ones()};
    scene.materials[2] = {"unused", Rgb::Zero(), Rgb::Ones()};
    scene.mesh.material[0] = 1;
    PointLight spot;
    spot.intensity = Rgb::Ones();
    spot.cos_outer = 0.5;
    spot.cos_inner = 0.6;
    scene.point_lights = {
        {Vec3::Zero(), Rgb::Ones()}, spot, {Vec3::Zero(), Rgb::Zero(), -Vec3::UnitZ(), -1, -1, "dark"}};
    scene.suns = {{Vec3::UnitZ(), Rgb::Ones(), "a"}, {Vec3::UnitZ(), Rgb::Ones()}};
    const std::vector<LightGroup> groups = light_groups(scene);
    ASSERT_EQ(groups.size(), 4U);
    EXPECT_EQ(groups[0].name, "a");
    EXPECT_EQ(groups[0].materials, (std::vector<char>{0, 1, 0}));
    EXPECT_EQ(groups[0].suns, (std::vector<char>{1, 0}));
    EXPECT_EQ(groups[1].name, "sun");
    EXPECT_EQ(groups[2].name, "point");
    EXPECT_EQ(groups[3].name, "spot");
}

/// Names are as files can hold them, and then no two groups have the same.
TEST(LightGroups, NamesThatFilesHold) {
    Scene scene = scene_of(rectangle(Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 2, 0), 2, 2), 0.5);
    const Vec3 up = Vec3::UnitZ();
    for (const char* name : {"a\x01", "a\x02", "a\n", "a_", "\xff", "\xed\xa0\x80", "ρ & <\"x\">"}) {
        scene.suns.push_back({up, Rgb::Ones(), name});
    }
    std::vector<std::string> names;
    for (const LightGroup& group : light_groups(scene)) {
        names.push_back(group.name);
    }
    EXPECT_EQ(names, (std::vector<std::string>{"a_", "_", "___", "ρ & <\"x\">"}));
}

/// What a scene does not have costs nothing: counted in rays.
TEST(OnlyWhatTheSceneNeeds, AConvexEmptyRoomCastsNoShadowRays) {
    Mesh mesh = plain_box(Vec3::Zero(), Vec3::Ones(), 2, Front::inside);
    ASSERT_TRUE(mesh.convex);
    Scene scene = scene_of(mesh, 0.5);
    scene.materials.resize(2);
    scene.materials[1].emission = Rgb::Ones();
    scene.mesh.material[40] = 1; // of 48: a lamp
    for (const char* transport : {"gather", "pairwise"}) {
        BakeOptions options = quick(0.2);
        options.transport = transport;
        const BakeResult result = baked(scene, options);
        EXPECT_EQ(result.lamps, 1U);
        EXPECT_EQ(result.segments, 0U) << transport;
        EXPECT_EQ(result.output_segments, 0U);
        EXPECT_EQ(result.channels, 1);
    }
    // A small block in it, and there are rays.
    add(scene.mesh, plain_box(Vec3::Constant(0.4), Vec3::Constant(0.6), 1, Front::outside), 0);
    EXPECT_FALSE(scene.mesh.convex);
    EXPECT_GT(baked(scene, quick(0.2)).segments, 0U);
}

TEST(OnlyWhatTheSceneNeeds, WithoutSharpLightsThereAreNoShadowRays) {
    Scene scene = scene_of(test::room_with_block(), 0.5);
    scene.materials[0].emission = Rgb::Ones();
    const BakeResult result = baked(scene, quick(0.2));
    EXPECT_EQ(result.segments, 0U);
    EXPECT_EQ(result.rays, result.sites->size() * 64);
    const auto saved = [&](const std::string& what) {
        return std::any_of(result.savings.begin(), result.savings.end(),
                           [&](const Saving& saving) { return saving.what == what && saving.amount > 0.0; });
    };
    EXPECT_TRUE(saved("sky"));
    EXPECT_TRUE(saved("two of three channels"));
    EXPECT_TRUE(saved("direct light by shadow rays"));
}

/// 256 lamps of different brightness close above a floor, of which far ones stand for each other: that is the only
/// error of the light on the floor, since nothing reflects, and the estimate and its bound tell it.
TEST(ManyLights, TheErrorOfStandingForEachOtherIsInsideTheBound) {
    constexpr int across = 16, kinds = 4;
    Scene scene = scene_of(rectangle(Vec3::Zero(), Vec3(4, 0, 0), Vec3(0, 4, 0)), 0.5);
    scene.materials.resize(1 + kinds);
    for (int kind = 1; kind <= kinds; ++kind) {
        Material& lamp = scene.materials[static_cast<std::size_t>(kind)];
        lamp.reflectance = Rgb::Zero();
        lamp.emission = Rgb::Constant(std::pow(3.0, kind));
    }
    RandomStream stream(1, "kinds");
    for (int i = 0; i < across; ++i) {
        for (int j = 0; j < across; ++j) {
            const Vec3 corner(0.25 * i + 0.1, 0.25 * j + 0.1, 0.5); // facing down
            add(scene.mesh, rectangle(corner, Vec3(0, 0.04, 0), Vec3(0.04, 0, 0)),
                1 + static_cast<Index>(stream.below(kinds)));
        }
    }
    BakeOptions options = quick(0.25);
    options.error_points = 512;
    const BakeResult result = baked(scene, options);
    ASSERT_EQ(result.lamps, 2U * across * across);
    const Mesh& mesh = result.scene->mesh;
    const std::vector<SurfacePoint> x = even_points(mesh, 400, RandomStream(2, "judged"));
    const PointValues values = result.solution.at(x, 0, 3, "judged", Execution{});
    double squares = 0.0, light = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        double H = 0.0;
        for (Index t = 2; t < mesh.triangles.size() && x[i].face < 2; ++t) {
            H += scene.materials[mesh.material[t]].emission[0] *
                 lambert_form_factor(x[i].position, x[i].normal, mesh.corner(t, 0), mesh.corner(t, 1),
                                     mesh.corner(t, 2));
        }
        const auto row = static_cast<Eigen::Index>(i);
        const double B = 0.5 * H; // of a lamp nobody asks
        squares += x[i].face < 2 ? std::pow(values.B(row, 0) - B, 2) : 0.0;
        light += B * B;
    }
    const double error = std::sqrt(squares / 400.0);
    EXPECT_GT(error, 1e-4 * std::sqrt(light / 400.0)); // they do stand for each other
    EXPECT_LT(error, 0.05 * std::sqrt(light / 400.0));
    ASSERT_TRUE(result.error);
    EXPECT_LE(error, result.error->bound_rms);
}

/// The outside of a closed room under no sky sees nothing: it gets no sites, and the inside as many as wanted.
TEST(OnlyWhatTheSceneNeeds, SitesAreNotSpentInTheDark) {
    Mesh mesh = plain_box(Vec3::Zero(), Vec3::Ones(), 2, Front::inside);
    add(mesh, plain_box(Vec3::Constant(-0.1), Vec3::Constant(1.1), 2, Front::outside), 0);
    Scene scene = scene_of(mesh, 0.5);
    scene.materials.resize(2);
    scene.materials[1].emission = Rgb(1, 2, 3);
    scene.mesh.material[40] = 1;
    BakeOptions options = quick(0.0);
    options.sites = 600;
    const BakeResult result = baked(scene, options);
    EXPECT_NEAR(static_cast<double>(result.sites->size()), 600.0, 60.0);
    for (const SurfacePoint& site : result.sites->points) {
        EXPECT_LT(site.face, 48U);
    }
    for (std::size_t v = 0; v < result.mesh.vertices.size(); ++v) {
        const double B = result.output.B(static_cast<Eigen::Index>(v), 0);
        EXPECT_EQ(B == 0.0, result.mesh.vertices[v].face >= 48U);
    }
    // Under a sky the outside has sites too.
    options.sky = Rgb::Ones();
    bool outside = false;
    const BakeResult lit = baked(scene, options);
    for (const SurfacePoint& site : lit.sites->points) {
        outside = outside || site.face >= 48U;
    }
    EXPECT_TRUE(outside);
}

/// A floor that sees nothing but a lamp of a ten thousandth of its size, or less, which no handful of rays meets.
TEST(OnlyWhatTheSceneNeeds, WhatALampLightsIsNotDark) {
    for (const double size : {10.0, 40.0, 400.0}) {
        for (const bool even : {true, false}) {
            Scene scene = scene_of(rectangle(Vec3(-size / 2, -size / 2, 0), Vec3(size, 0, 0), Vec3(0, size, 0)), 0.5);
            scene.materials.resize(2);
            scene.materials[1].emission = Rgb::Constant(100.0);
            if (!even) { // no lamp: left to the rays
                scene.materials[1].emission_pattern = [](const Vec3&) { return 1.0; };
            }
            add(scene.mesh, rectangle(Vec3(0, 0, 3), Vec3(0, 0.3, 0), Vec3(0.3, 0, 0)), 1); // facing down
            BakeOptions options = quick(0.0, 16);
            options.sites = 300;
            const BakeResult result = baked(scene, options);
            EXPECT_NEAR(static_cast<double>(result.sites->size()), 300.0, 60.0) << size;
        }
    }
}

/// A lamp that hangs with its back to the room lights nothing, which is said.
TEST(Bake, SaysWhichEmittersFaceAway) {
    Scene scene = scene_of(plain_box(Vec3::Zero(), Vec3::Ones(), 1, Front::inside), 0.5);
    scene.materials.resize(2);
    scene.materials[1].name = "bulb";
    scene.materials[1].emission = Rgb::Ones();
    add(scene.mesh, rectangle(Vec3(0.4, 0.4, 2), Vec3(0.1, 0, 0), Vec3(0, 0.1, 0)), 1); // above the room, facing up
    scene.point_lights = {{Vec3(0.5, 0.5, 0.5), Rgb::Ones()}};
    const BakeResult result = baked(scene, quick(0.3));
    const bool said = std::any_of(result.notes.begin(), result.notes.end(), [](const std::string& note) {
        return note.find("2 emitting triangles light nothing, the first of them of face 12 (material bulb)") == 0;
    });
    EXPECT_TRUE(said);
    add(scene.mesh, rectangle(Vec3(0.4, 0.4, 0.9), Vec3(0, 0.1, 0), Vec3(0.1, 0, 0)), 1); // in the room, facing down
    scene.point_lights.clear();
    EXPECT_NO_THROW(baked(scene, quick(0.3)));
}

/// Places that a user lists, off the surface, and the centres of faces: in a furnace the light is known.
TEST(Bake, EvaluatesListedPlacesAndCentres) {
    Scene scene = test::uniform_scene(plain_box(Vec3::Zero(), Vec3::Ones(), 2, Front::inside), 0.5, 1.0);
    add(scene.mesh, plain_box(Vec3::Constant(0.4), Vec3::Constant(0.6), 1, Front::outside), 0);
    BakeOptions options = quick(0.2);
    options.face_centres = true;
    options.at = {{Vec3(0.5, 0.5, -0.01), {}}, {Vec3(0.5, 0.5, 0.39), {}}, {Vec3(0.5, 0.5, 0.39), Vec3::UnitZ()}};
    const BakeResult result = baked(scene, options);
    ASSERT_EQ(result.listed.size(), 3U);
    EXPECT_TRUE(result.listed[0].position.isApprox(Vec3(0.5, 0.5, 0.0)));
    EXPECT_NEAR(result.listed_distance[0], 0.01, 1e-12);
    EXPECT_EQ(result.listed[1].normal, -Vec3::UnitZ()); // the block's bottom
    EXPECT_EQ(result.listed[2].normal, Vec3::UnitZ());  // not the bottom: the block's top
    EXPECT_NEAR(result.listed[2].position.z(), 0.6, 1e-12);
    ASSERT_TRUE(result.centres);
    EXPECT_EQ(result.centres->B.rows(), std::ssize(result.mesh.triangles));
    for (const Values* B : {&result.listed_values.B, &result.centres->B}) {
        EXPECT_LT((B->array() - 2.0).abs().maxCoeff(), 1e-10);
    }
}

} // namespace
} // namespace difusa
