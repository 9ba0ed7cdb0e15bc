#include <difusa/bake.h>
#include <difusa/core/random.h>
#include <difusa/import/shapes.h>
#include <difusa/lighting/surfel_light.h>
#include <difusa/rays/brute_force.h>

#include <support/plugins.h>
#include <support/rooms.h>
#include <support/sited.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace difusa::surfel_light_test {
namespace {

/// The light of a scene on surfels of some size.
struct Lit {
    BruteForceVisibility visibility;
    Surfels surfels;
    DirectLight direct;
    SurfelLight light;

    Lit(const Scene& scene, double edge, bool groups = false, unsigned threads = 1)
        : visibility(built(scene)), surfels(scene.mesh, edge, Execution{}),
          direct(scene, {scene.mesh, visibility}, groups ? light_groups(scene) : all_lights(scene)),
          light(light_on_surfels(scene, surfels, direct, 3, 7, Execution{threads})) {}

    static BruteForceVisibility built(const Scene& scene) {
        BruteForceVisibility visibility;
        visibility.build(scene.mesh);
        return visibility;
    }

    /// ∫ of means over the surface, those of which `counts` says so.
    template <class Counts> double integral(const Values& means, Eigen::Index column, const Counts& counts) const {
        std::vector<Surfels::Piece> pieces;
        double sum = 0.0;
        for (Index s = 0; s < surfels.size(); ++s) {
            surfels.pieces(s, pieces);
            sum += counts(pieces[0].triangle) ? surfels.area(s) * means(static_cast<Eigen::Index>(s), column) : 0.0;
        }
        return sum;
    }
    double integral(const Values& means, Eigen::Index column) const {
        return integral(means, column, [](Index) { return true; });
    }
};

TEST(SurfelLight, ConstantMaterialsAreExact) {
    for (const int n : {1, 12}) { // large triangles, and clusters of small ones
        Scene scene = test::uniform_scene(test::box(1.0, n, true), 0.3, 0.0);
        scene.materials.push_back(scene.materials[0]);
        scene.materials[1].reflectance = Rgb(0.1, 0.7, 0.9);
        scene.materials[1].emission = Rgb(2, 0, 1);
        const auto sides = static_cast<Index>(scene.mesh.triangles.size() / 6);
        for (Index t = 0; t < 3 * sides; ++t) { // too much of the surface to be an area light
            scene.mesh.material[t] = 1;
        }
        const Lit lit(scene, 0.1);
        EXPECT_EQ(lit.direct.area_light_count(), 0U);
        EXPECT_EQ(lit.light.segments, 0U);
        std::vector<Surfels::Piece> pieces;
        for (Index s = 0; s < lit.surfels.size(); ++s) {
            lit.surfels.pieces(s, pieces);
            const Material& material = scene.materials[scene.mesh.material[pieces[0].triangle]];
            const auto row = static_cast<Eigen::Index>(s);
            for (int c = 0; c < 3; ++c) { // sums of shares, of so many pieces
                const double rounding = 2.0 * static_cast<double>(pieces.size()) * 0x1p-53;
                EXPECT_NEAR(lit.light.reflectance(row, c), material.reflectance[c], rounding);
                EXPECT_NEAR(lit.light.emission(row, c), material.emission[c], 2.0 * rounding);
                EXPECT_EQ(lit.light.all_emission(row, c), lit.light.emission(row, c));
                EXPECT_EQ(lit.light.direct(row, c), 0.0);
                EXPECT_EQ(lit.light.from_outside(row, c), 0.0);
            }
        }
    }
}

/// Colours of corners are linear over a triangle. 16 points, each in a stratum of its own along one axis and at the
/// multiples of the golden ratio along the other, have a discrepancy below 0.15, and the colour varies by at most twice
/// the extent of a surfel over it (Koksma and Hlawka): per surfel 0.3 edges, of which next to nothing is left in sum.
TEST(SurfelLight, ColoursOfCornersAreAveraged) {
    Scene scene = test::uniform_scene(test::grid(2, 2), 1.0, 0.0);
    scene.materials[0].vertex_colours = true;
    const auto rho = [](const Vec3& p) { return Rgb(p.x(), p.y(), 1.0 - p.x()); };
    for (Index t = 0; t < scene.mesh.triangles.size(); ++t) {
        scene.mesh.corner_reflectance.push_back(
            {rho(scene.mesh.corner(t, 0)), rho(scene.mesh.corner(t, 1)), rho(scene.mesh.corner(t, 2))});
    }
    const double edge = 0.08;
    const Lit lit(scene, edge);
    std::vector<Surfels::Piece> pieces;
    for (Index s = 0; s < lit.surfels.size(); ++s) {
        const Rgb exact = rho(lit.surfels.centre(s, pieces).position);
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(lit.light.reflectance(static_cast<Eigen::Index>(s), c), exact[c], 0.3 * edge);
        }
    }
    EXPECT_NEAR(lit.integral(lit.light.reflectance, 0), 0.5, 0.3 * edge * 0.1);
    EXPECT_NEAR(lit.integral(lit.light.reflectance, 0) + lit.integral(lit.light.reflectance, 2), 1.0, 1e-12);
}

/// A pattern that is 1 or 0: the mean over a surfel is a whole number of its 16 points.
TEST(SurfelLight, PatternsOfEmissionAreAveraged) {
    Scene scene = test::uniform_scene(test::grid(1, 1), 0.5, 4.0);
    scene.materials[0].emission_pattern = [](const Vec3& p) { return p.x() < 0.4 ? 1.0 : 0.0; };
    const double edge = 0.05;
    const Lit lit(scene, edge);
    EXPECT_EQ(lit.light.emission, lit.light.all_emission);
    int between = 0;
    for (Index s = 0; s < lit.surfels.size(); ++s) {
        const double sixteenths = 4.0 * lit.light.emission(static_cast<Eigen::Index>(s), 0);
        EXPECT_EQ(sixteenths, std::round(sixteenths));
        between += sixteenths > 0.0 && sixteenths < 16.0 ? 1 : 0;
    }
    EXPECT_GT(between, 5);
    // Only surfels that the line x = 0.4 crosses err, at most by their share of it: a strip of their width.
    EXPECT_NEAR(lit.integral(lit.light.emission, 0), 4.0 * 0.4, 4.0 * 2.0 * edge * 0.3);
}

/// A display of 64 by 64 pixels, dark but for 16 that are far apart: none of these is missed. The energy balance tells
/// their power exactly, because interpolated pixels are patterns of the second degree on the parts that it adds up.
TEST(SurfelLight, SmallBrightPixelsAreNotMissed) {
    constexpr int N = 64;
    Image image;
    image.width = image.height = N;
    image.pixels.assign(N * N, {0.0F, 0.0F, 0.0F});
    for (int i = 0; i < 16; ++i) {
        const int row = 6 + 16 * (i / 4), column = 5 + 16 * (i % 4);
        image.pixels[static_cast<std::size_t>(row * N + column)] = {1.0F, 0.5F, 0.25F};
    }
    Scene scene = test::uniform_scene(test::grid(1, 1), 0.5, 4.0);
    scene.materials[0].emission_texture = std::make_shared<Texture>(image);
    for (const std::array<Index, 3>& corners : scene.mesh.triangles) {
        std::array<TextureCoordinates, 3> uv;
        for (std::size_t k = 0; k < 3; ++k) {
            uv[k] = scene.mesh.points[corners[k]].head<2>();
        }
        scene.mesh.corner_texture.push_back(uv);
        EXPECT_DOUBLE_EQ(scene.pixels_of_emission(static_cast<Index>(scene.mesh.corner_texture.size() - 1)),
                         0.5 * N * N);
    }
    const double power = 4.0 * 16.0 / (N * N);
    // A pixel has 16 points in the place of its bilinear hat, which are spread more evenly than at random: independent
    // ones would make the sum of 16 pixels off by 1/16 (one standard deviation).
    for (const double edge : {0.03, 0.1, 0.5}) {
        const Lit lit(scene, edge);
        EXPECT_NEAR(lit.integral(lit.light.emission, 0), power, 4.0 / 16.0 * power) << edge;
        EXPECT_NEAR(lit.integral(lit.light.emission, 1), 0.5 * lit.integral(lit.light.emission, 0), 1e-12);
    }
    BakeOptions options;
    options.sites = 100;
    options.rays = 16;
    options.error_points = 0;
    const BakeResult result = bake(test::registry(), scene, "display", options, Execution{});
    EXPECT_NEAR(result.solution.energy.emitted[0], power, 1e-12);
    EXPECT_NEAR(result.solution.energy.emitted[1], 0.5 * power, 1e-12);
}

/// A room with a small lamp, a sun that shines in, a point light and an emitting wall.
Scene lit_room() {
    Scene scene;
    Mesh& mesh = scene.mesh;
    mesh = rectangle(Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 4, 0));
    add(mesh, rectangle(Vec3(0, 4, 0), Vec3(4, 0, 0), Vec3(0, 0, 2)), 1);
    add(mesh, rectangle(Vec3(2, 1, 1.9), Vec3(0, 0.3, 0), Vec3(0.3, 0, 0)), 2);
    add(mesh, rectangle(Vec3(1, 1, 1), Vec3(1, 0, 0), Vec3(0, 1, 0)), 0); // a table
    scene.materials.resize(3);
    for (std::size_t m = 0; m < 3; ++m) {
        scene.materials[m].name = "material " + std::to_string(m);
        scene.materials[m].reflectance = Rgb(0.5, 0.4, 0.3);
    }
    scene.materials[1].emission = Rgb(0.1, 0.2, 0.3);
    scene.materials[2].emission = Rgb(30, 20, 10);
    scene.suns.push_back({Vec3(0.2, -0.3, 1).normalized(), Rgb(3, 2, 1)});
    PointLight bulb;
    bulb.position = Vec3(3, 3, 1);
    bulb.intensity = Rgb(1, 1, 1);
    scene.point_lights.push_back(bulb);
    return scene;
}

TEST(SurfelLight, TheEmissionOfAreaLightsIsCountedOnce) {
    const Scene scene = lit_room();
    const Lit lit(scene, 0.1);
    ASSERT_EQ(lit.direct.area_light_materials(), (std::vector<char>{0, 0, 1}));
    std::vector<Surfels::Piece> pieces;
    for (Index s = 0; s < lit.surfels.size(); ++s) {
        lit.surfels.pieces(s, pieces);
        const Index m = scene.mesh.material[pieces[0].triangle];
        for (int c = 0; c < 3; ++c) {
            EXPECT_DOUBLE_EQ(lit.light.all_emission(static_cast<Eigen::Index>(s), c), scene.materials[m].emission[c]);
            EXPECT_DOUBLE_EQ(lit.light.emission(static_cast<Eigen::Index>(s), c),
                             m == 2 ? 0.0 : scene.materials[m].emission[c]);
        }
    }
    // Of the direct light only that of sun and bulb comes from outside.
    EXPECT_TRUE((lit.light.from_outside.array() <= lit.light.direct.array() * (1.0 + 1e-14)).all());
    EXPECT_GT(lit.integral(lit.light.direct, 0), lit.integral(lit.light.from_outside, 0) + 0.1);
    const Values bounce = lit.light.first_bounce();
    EXPECT_EQ(bounce, lit.light.direct.cwiseProduct(lit.light.reflectance));
}

TEST(SurfelLight, SetsAddUpToAllLights) {
    const Scene scene = lit_room();
    const Lit one(scene, 0.1), sets(scene, 0.1, true), threads(scene, 0.1, true, 3);
    EXPECT_EQ(sets.light.direct, threads.light.direct);
    EXPECT_EQ(sets.light.emission, threads.light.emission);
    EXPECT_EQ(sets.light.segments, threads.light.segments);
    EXPECT_EQ(sets.direct.sets().names, (std::vector<std::string>{"material 1", "material 2", "sun", "point"}));
    ASSERT_EQ(sets.light.direct.cols(), 12);
    EXPECT_EQ(sets.light.segments, one.light.segments);
    Values direct = Values::Zero(one.light.direct.rows(), 3), emission = direct, bounce = direct;
    const Values first_bounce = sets.light.first_bounce();
    for (Eigen::Index set = 0; set < 4; ++set) {
        direct += sets.light.direct.middleCols(3 * set, 3);
        emission += sets.light.emission.middleCols(3 * set, 3);
        bounce += first_bounce.middleCols(3 * set, 3);
    }
    // Sums of up to 80 samples in another order.
    const double rounding = 100 * 0x1p-53;
    EXPECT_LE((direct - one.light.direct).cwiseAbs().maxCoeff(), rounding * direct.maxCoeff());
    EXPECT_EQ(emission, one.light.emission);
    EXPECT_LE((bounce - one.light.first_bounce()).cwiseAbs().maxCoeff(), rounding * bounce.maxCoeff());
    EXPECT_LE((sets.light.from_outside - one.light.from_outside).cwiseAbs().maxCoeff(), rounding * direct.maxCoeff());
    EXPECT_EQ(sets.light.reflectance, one.light.reflectance);
    // What each set has is where it should be.
    EXPECT_EQ(sets.light.direct.leftCols(3).norm(), 0.0) << "the wall is no area light";
    EXPECT_EQ(sets.light.emission.rightCols(9).norm(), 0.0);
}

/// A sun above a square hole of 1 m²: as much light reaches the floor as passes the hole.
TEST(SurfelLight, TheSunThroughAHoleBringsItsFlux) {
    Scene scene;
    Mesh& mesh = scene.mesh;
    mesh = rectangle(Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 4, 0));
    const auto ceiling = [&](double x0, double x1, double y0, double y1) {
        add(mesh, rectangle(Vec3(x0, y0, 2), Vec3(0, y1 - y0, 0), Vec3(x1 - x0, 0, 0)), 0);
    };
    ceiling(-9, 13, -9, 1.5);
    ceiling(-9, 13, 2.5, 13);
    ceiling(-9, 1.5, 1.5, 2.5);
    ceiling(2.5, 13, 1.5, 2.5);
    scene.materials.resize(1);
    const Vec3 towards = Vec3(0.1, 0.2, 1).normalized();
    scene.suns.push_back({towards, Rgb(1, 2, 3)});
    const double edge = 0.05;
    const Lit lit(scene, edge);
    const double flux = towards.z();
    // A surfel on the border of the lit square has a share of light that 12 points tell, or 96: as if these were
    // independent, its standard deviation is below 1/2 over the root of 12. The border of 4 m crosses at most 2 * 4 /
    // edge squares or parts of such.
    const double cells = 8.0 / edge, area = edge * edge;
    const double bound = flux * area * 4.5 * 0.5 / std::sqrt(12.0) * std::sqrt(cells);
    const auto on_floor = [](Index t) { return t < 2; };
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(lit.integral(lit.light.direct, c, on_floor), (c + 1) * flux, (c + 1) * bound);
    }
    EXPECT_EQ(lit.light.direct, lit.light.from_outside);
    EXPECT_GE(lit.light.segments, static_cast<std::size_t>(4 * 16.0 / area)); // the ceiling faces away from the sun
    // Surfels that are wholly in the light or out of it are exact.
    std::vector<Surfels::Piece> pieces;
    int inside = 0, border = 0;
    for (Index s = 0; s < lit.surfels.size(); ++s) {
        const SurfacePoint x = lit.surfels.centre(s, pieces);
        if (x.face >= 2) {
            continue;
        }
        const Vec3 above = x.position + towards * 2.0 / towards.z();
        const double within = std::min({above.x() - 1.5, 2.5 - above.x(), above.y() - 1.5, 2.5 - above.y()});
        if (std::abs(within) > 1.5 * edge) {
            EXPECT_NEAR(lit.light.direct(static_cast<Eigen::Index>(s), 0), within > 0.0 ? flux : 0.0, 8 * 0x1p-53);
            EXPECT_EQ(lit.light.even[s], 1);
            inside += within > 0.0 ? 1 : 0;
        }
        if (const double share = lit.light.direct(static_cast<Eigen::Index>(s), 0) / flux; share > 0.4 && share < 0.6) {
            EXPECT_EQ(lit.light.even[s], 0);
            ++border;
        }
    }
    EXPECT_GT(inside, 200);
    EXPECT_GT(border, 5);
}

/// Spots whose beams are narrower than a surfel, so that four points of it may all be in the dark.
TEST(SurfelLight, NarrowBeamsBringTheirFlux) {
    constexpr double pi = std::numbers::pi;
    constexpr int seeds = 16;
    for (const double degrees : {0.5, 1.0, 3.0, 6.0}) {
        Scene scene;
        scene.mesh = rectangle(Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 4, 0));
        scene.materials.resize(1);
        PointLight spot;
        spot.position = Vec3(1.2, 1.7, 2.0);
        spot.direction = Vec3(0.21, 0.17, -1).normalized();
        spot.cos_outer = std::cos(degrees * pi / 180.0);
        spot.cos_inner = spot.cos_outer + 1e-12;
        const double flux = 2.0 * pi * (1.0 - spot.cos_outer);
        spot.intensity = Rgb(1, 2, 3) / flux;
        scene.point_lights.push_back(spot);
        const Lit lit(scene, 0.2);
        double mean = 0.0;
        for (int seed = 0; seed < seeds; ++seed) {
            const SurfelLight light = light_on_surfels(scene, lit.surfels, lit.direct, 3, seed, Execution{2});
            mean += lit.integral(light.direct, 0) / seeds;
        }
        // About 96 points are in the beam. As if they were independent: 4.5 standard deviations.
        EXPECT_NEAR(mean, 1.0, 4.5 / std::sqrt(96.0 * seeds)) << degrees;
        RandomStream random(3, "places");
        for (int i = 0; i < 60; ++i) { // none of these places is lost between the points of the pilots
            scene.point_lights.front().position.head<2>() =
                Eigen::Vector2d(1.0 + random.uniform(), 1.0 + random.uniform());
            const Lit elsewhere(scene, 0.2);
            EXPECT_NEAR(elsewhere.integral(elsewhere.light.direct, 0), 1.0, 4.5 / std::sqrt(96.0)) << degrees;
        }
        for (Eigen::Index s = 0; s < lit.light.direct.rows(); ++s) {
            EXPECT_FALSE(lit.light.direct(s, 0) > 0.0 && lit.light.even[static_cast<std::size_t>(s)] != 0);
        }
    }
}

/// A lamp half behind a plate: surfels in the penumbra have the mean of what arrives there. (Samples that are taken
/// until they disagree, and count themselves, are 5 % above it where a lamp is mostly in sight.)
TEST(SurfelLight, PenumbraeAreUnbiased) {
    Scene scene;
    scene.mesh = rectangle(Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0));
    add(scene.mesh, rectangle(Vec3(-1, -1, 1), Vec3(0, 3, 0), Vec3(1.5, 0, 0)), 0);
    add(scene.mesh, rectangle(Vec3(0.25, 0.25, 2), Vec3(0, 0.5, 0), Vec3(0.5, 0, 0)), 1);
    scene.materials.resize(2);
    scene.materials[1].emission = Rgb::Ones();
    const Lit lit(scene, 0.2);
    ASSERT_EQ(lit.direct.area_light_count(), 2U);
    constexpr int seeds = 120, across = 12;
    std::vector<double> ratio; // of the light of a seed to what is exact, in the penumbra
    std::vector<Index> penumbra;
    std::vector<double> exact;
    std::vector<Surfels::Piece> pieces;
    for (Index s = 0; s < lit.surfels.size(); ++s) {
        const SurfacePoint centre = lit.surfels.centre(s, pieces);
        if (centre.face >= 2 || std::abs(centre.position.x() - 0.67) > 0.1) { // two thirds to all of the lamp in sight
            continue;
        }
        DirectLight::Worker worker;
        RandomStream stream(5, "exact", s);
        double sum = 0.0;
        for (int i = 0; i < across * across; ++i) {
            const SurfacePoint x =
                lit.surfels.point_on(pieces, (i % across + 0.5) / across, (i / across + 0.5) / across);
            sum += lit.direct.irradiance(x, 64, stream, worker)[0];
        }
        penumbra.push_back(s);
        exact.push_back(sum / (across * across));
    }
    ASSERT_GE(penumbra.size(), 4U);
    for (int seed = 0; seed < seeds; ++seed) {
        const SurfelLight light =
            light_on_surfels(scene, lit.surfels, lit.direct, 1, static_cast<std::uint64_t>(seed), Execution{});
        double mean = 0.0;
        for (std::size_t k = 0; k < penumbra.size(); ++k) {
            mean += light.direct(static_cast<Eigen::Index>(penumbra[k]), 0) / exact[k];
        }
        ratio.push_back(mean / static_cast<double>(penumbra.size()));
    }
    double mean = 0.0, squares = 0.0;
    for (const double each : ratio) {
        mean += each / seeds;
        squares += each * each / seeds;
    }
    const double standard_error = std::sqrt((squares - mean * mean) / (seeds - 1));
    EXPECT_LT(standard_error, 0.003);
    EXPECT_NEAR(mean, 1.0, 4.5 * standard_error);
}

} // namespace
} // namespace difusa::surfel_light_test
