// Skies against closed forms and lamps of their shape, and the suns of their images.
#include <difusa/bake.h>
#include <difusa/import/shapes.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/rays/brute_force.h>
#include <difusa/rays/lambert.h>
#include <difusa/scene/sky_dome.h>
#include <difusa/scene/sky_parts.h>
#include <difusa/transport/gathered.h>

#include <support/lit_scenes.h>

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

namespace difusa::skies_test {
namespace {

using namespace lit;

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
    const Surfels surfels(scene.mesh, 30.0, Execution{});
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
        const LightTransport transport = gathered({scene.mesh, visibility}, x, surfels,
                                                  *test::plugin<Directions>("low-discrepancy"), N, 1, Execution{});
        Values H;
        transport.gather(Values::Zero(static_cast<Eigen::Index>(surfels.size()), 1), sky_radiosity(scene, 1), H,
                         Execution{});
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
    const std::vector<Sun> further = sky.split_suns(8.0); // of what is left
    EXPECT_TRUE(further.empty() || further[0].irradiance.mean() < suns[0].irradiance.mean());
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

} // namespace
} // namespace difusa::skies_test
