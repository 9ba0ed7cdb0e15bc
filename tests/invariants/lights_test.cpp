// Point lights, suns and lamps against closed forms.
#include <difusa/bake.h>
#include <difusa/import/shapes.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/rays/lambert.h>

#include <support/lit_scenes.h>

#include <gtest/gtest.h>

#include <cmath>

namespace difusa::lights_test {
namespace {

using namespace lit;

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
    EXPECT_NEAR(result.solution.energy.from_lights[0], 12.0 * pi, 12.0 * pi * 0.01);
    EXPECT_LT(std::abs(result.solution.energy.imbalance[0]), 1e-2);
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
        const PointValues values = result.field().at(x, 0, 1, "test", Execution{});
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

/// A strip of 4232 lamps of different brightness close above a floor, of which far ones stand for each other: that is
/// the only error of the light on the floor, since nothing reflects, and the estimate and its bound tell it.
TEST(ManyLights, TheErrorOfStandingForEachOtherIsInsideTheBound) {
    constexpr int across = 46, kinds = 4;
    Scene scene = scene_of(rectangle(Vec3::Zero(), Vec3(4, 0, 0), Vec3(0, 4, 0)), 0.5);
    scene.materials.resize(1 + kinds);
    for (int kind = 1; kind <= kinds; ++kind) {
        Material& lamp = scene.materials[static_cast<std::size_t>(kind)];
        lamp.reflectance = Rgb::Zero();
        lamp.emission = Rgb::Constant(std::pow(3.0, kind));
    }
    add(scene.mesh, rectangle(Vec3(0.1, 1.7, 0.5), Vec3(0, 0.4, 0), Vec3(3.8, 0, 0), across, across), 1); // facing down
    RandomStream stream(1, "kinds");
    for (Index t = 2; t < scene.mesh.triangles.size(); ++t) {
        scene.mesh.material[t] = 1 + static_cast<Index>(stream.below(kinds));
    }
    BakeOptions options = quick(0.25);
    options.error_points = 512;
    const BakeResult result = baked(scene, options);
    ASSERT_EQ(result.solution.area_lights, 2U * across * across);
    const Mesh& mesh = result.scene->mesh;
    const std::vector<SurfacePoint> x = even_points(mesh, 400, RandomStream(2, "judged"));
    const PointValues values = result.field().at(x, 0, 3, "judged", Execution{});
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
    EXPECT_LE(error, result.error->bound);
}

} // namespace
} // namespace difusa::lights_test
