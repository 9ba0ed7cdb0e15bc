// Scene files: lights, skies and cameras.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "scene_file_fixture.h"

namespace difusa::scene_file_lights_test {
namespace {

using test::bright_spot;
using test::SceneFile;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST_F(SceneFile, Lights) {
    const PolygonSoup soup = with(
        "\"unit\": \"cm\", \"lights\": [{\"type\": \"sun\", \"towards\": [0, 3, 4], \"irradiance\": 5}, {\"type\": "
        "\"point\", \"name\": \"p\", \"position\": [100, 200, 300], \"power\": [4, 8, 12]}, {\"type\": \"spot\", "
        "\"position\": [0, 0, 200], \"look_at\": [0, 0, 0], \"intensity\": 7, \"outer_degrees\": 60}, {\"type\": "
        "\"spot\", \"position\": [0, 0, 0], \"direction\": [2, 0, 0], \"intensity\": 7, \"inner_degrees\": 30, "
        "\"outer_degrees\": 30}]");
    ASSERT_EQ(soup.lights.suns.size(), 1U);
    EXPECT_LT((soup.lights.suns[0].towards - Vec3(0, 0.6, 0.8)).norm(), 1e-15);
    EXPECT_TRUE((soup.lights.suns[0].irradiance == 5.0).all());
    ASSERT_EQ(soup.lights.points.size(), 3U);
    const PointLight &point = soup.lights.points[0], &spot = soup.lights.points[1];
    EXPECT_EQ(point.name, "p");
    EXPECT_EQ(point.position, Vec3(1, 2, 3));
    EXPECT_FALSE(point.is_spot());
    // Intensity in all directions adds up to the power.
    EXPECT_NEAR(point.intensity[2] * 4.0 * std::numbers::pi, 12.0, 1e-14);
    EXPECT_EQ(spot.position, Vec3(0, 0, 2));
    EXPECT_EQ(spot.direction, Vec3(0, 0, -1));
    EXPECT_EQ(spot.falloff(Vec3(0, 0, -1)), 1.0);
    EXPECT_NEAR(spot.falloff(Vec3(std::sin(1.0), 0, -std::cos(1.0))), std::pow((std::cos(1.0) - 0.5) / 0.5, 2), 1e-14);
    EXPECT_EQ(soup.lights.points[2].direction, Vec3(1, 0, 0));
    EXPECT_EQ(soup.lights.points[2].cos_inner, soup.lights.points[2].cos_outer);
}

TEST_F(SceneFile, LightsMeasuredInLumens) {
    // 683 lm, cd, lux or cd/m^2 are one W, W/sr, W/m^2 or W/(m^2 sr).
    const PolygonSoup soup =
        with("\"lights\": [{\"type\": \"sun\", \"towards\": [0, 0, 1], \"illuminance\": [683, 1366, 0]},"
             "{\"type\": \"point\", \"position\": [1, 2, 3], \"luminous_flux\": 6830},"
             "{\"type\": \"spot\", \"position\": [0, 0, 2], \"look_at\": [0, 0, 0], \"luminous_intensity\": 2049,"
             "\"outer_degrees\": 30}], \"sky\": {\"type\": \"uniform\", \"illuminance\": 2732},"
             "\"materials\": {\"screen\": {\"luminance\": 683}}");
    EXPECT_TRUE(soup.photometric);
    EXPECT_LT((soup.lights.suns[0].irradiance - Rgb(1, 2, 0)).abs().maxCoeff(), 1e-15);
    EXPECT_NEAR(soup.lights.points[0].intensity[0] * 4.0 * std::numbers::pi, 10.0, 1e-14);
    EXPECT_NEAR(soup.lights.points[1].intensity[1], 3.0, 1e-15);
    EXPECT_NEAR((*soup.lights.sky)[2], 4.0, 1e-15);
    EXPECT_NEAR(soup.materials[0].emission[0], std::numbers::pi, 1e-15);
    const PolygonSoup gradient = with("\"sky\": {\"type\": \"gradient\", \"zenith\": 683, \"horizon\": 0, "
                                      "\"ground\": 0, \"photometric\": true}");
    EXPECT_TRUE(gradient.photometric);
    EXPECT_NEAR(gradient.lights.dome->radiance(Vec3(0, 0, 1))[0], 1.0, 1e-15);
    EXPECT_FALSE(with("\"sky\": {\"type\": \"uniform\", \"irradiance\": 1}").photometric);
    EXPECT_THAT(refused_with("\"sky\": {\"type\": \"uniform\", \"irradiance\": 1, \"illuminance\": 1}"),
                HasSubstr("has both \"irradiance\" and \"illuminance\""));
    EXPECT_THAT(refused_with("\"lights\": [{\"type\": \"point\", \"position\": [0, 0, 0], \"intensity\": 1, "
                             "\"luminous_intensity\": 1}]"),
                HasSubstr("has both \"intensity\" and \"luminous_intensity\""));
}

TEST_F(SceneFile, Skies) {
    EXPECT_TRUE(
        (*with("\"sky\": {\"type\": \"uniform\", \"irradiance\": [1, 2, 3]}").lights.sky == Rgb(1, 2, 3)).all());
    const PolygonSoup gradient =
        with("\"up\": \"y\", \"sky\": {\"type\": \"gradient\", \"zenith\": 4, \"horizon\": 2, \"ground\": 1}");
    ASSERT_TRUE(gradient.lights.dome);
    EXPECT_EQ(gradient.lights.dome->radiance(Vec3(0, 1, 0))[0], 4.0);
    EXPECT_EQ(gradient.lights.dome->radiance(Vec3(0.8, 0.6, 0))[0], 2.0 + 0.6 * 2.0);
    EXPECT_EQ(gradient.lights.dome->radiance(Vec3(0, -1, 0))[0], 1.0);
}

TEST_F(SceneFile, ASkysBrightSpotsBecomeSuns) {
    write("sky.hdr", bright_spot(10, 40));
    const PolygonSoup soup = with("\"sky\": {\"type\": \"image\", \"file\": \"sky.hdr\", \"scale\": 2}");
    ASSERT_EQ(soup.lights.suns.size(), 1U);
    ASSERT_TRUE(soup.lights.dome);
    const Sun& sun = soup.lights.suns[0];
    EXPECT_EQ(sun.name, "sky");
    EXPECT_TRUE(sun.of_sky);
    EXPECT_THAT(soup.notes, testing::ElementsAre(HasSubstr("its brightest spots become suns: 1")));
    // The middle column lies towards y, the next ones to the right of it, x.
    const double polar = 10.5 / 32.0 * std::numbers::pi, azimuth = (40.5 / 64.0 - 0.5) * 2.0 * std::numbers::pi;
    EXPECT_LT(
        (sun.towards - Vec3(std::sin(polar) * std::sin(azimuth), std::sin(polar) * std::cos(azimuth), std::cos(polar)))
            .norm(),
        1e-12);
    // What the sun has and what is left add up to the image: 512 times the solid angle of the pixel.
    const double step = std::numbers::pi / 32.0;
    const double size = 2.0 * std::numbers::pi / 64.0 * (std::cos(10 * step) - std::cos(11 * step));
    const double left = soup.lights.dome->radiance(sun.towards)[0];
    EXPECT_NEAR(sun.irradiance[0] + left * size, 512.0 * size, 1e-6 * 512.0 * size);
    // Ten times the mean of the sphere is left: 2 everywhere and 510 more in the pixel.
    EXPECT_NEAR(left, 10.0 * (2.0 + 510.0 * size / (4.0 * std::numbers::pi)), 1e-5);

    const PolygonSoup whole =
        with("\"sky\": {\"type\": \"image\", \"file\": \"sky.hdr\", \"split_suns\": false, \"ahead\": "
             "[1, 0, 5]}");
    EXPECT_THAT(whole.lights.suns, IsEmpty());
    EXPECT_NEAR(whole.lights.dome->radiance(Vec3(std::sin(polar) * std::cos(azimuth),
                                                 -std::sin(polar) * std::sin(azimuth), std::cos(polar)))[0],
                256.0, 1e-9);
}

TEST_F(SceneFile, BrightSpotsTooWideForSunsAreNoted) {
    // A pixel here is 0.0095 sr wide at the horizon: two of them are no sun.
    std::string hdr = bright_spot(15, 40);
    hdr[hdr.size() - 4U * (32 * 64 - 15 * 64 - 41) + 3] = '\x89';
    write("sky.hdr", hdr);
    const PolygonSoup soup = with("\"sky\": {\"type\": \"image\", \"file\": \"sky.hdr\"}");
    EXPECT_THAT(soup.lights.suns, IsEmpty());
    EXPECT_THAT(soup.notes, testing::ElementsAre(HasSubstr("sr remain more than 20 times as bright as its mean")));
    EXPECT_THAT(with("\"sky\": {\"type\": \"image\", \"file\": \"sky.hdr\", \"split_suns\": false}").notes, IsEmpty());
}

TEST_F(SceneFile, ASkyOfManySpotsDoesNotBecomeManySuns) {
    std::string hdr = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 32 +X 64\n";
    for (int r = 0; r < 32; ++r) {
        for (int c = 0; c < 64; ++c) {
            hdr += std::string("\x80\x80\x80", 3) +
                   (r % 4 == 1 && c % 16 == 3 ? static_cast<char>(0x88 + (r == 13 ? c / 16 : 0)) : '\x78');
        }
    }
    write("sky.hdr", hdr);
    const PolygonSoup soup = with("\"sky\": {\"type\": \"image\", \"file\": \"sky.hdr\"}");
    EXPECT_GE(soup.lights.suns.size(), 1U);
    EXPECT_LE(soup.lights.suns.size(), 16U);
}

TEST_F(SceneFile, Cameras) {
    const PolygonSoup soup =
        with("\"unit\": 2, \"up\": [0, 2, 0], \"camera\": {\"eye\": [1, 2, 3], \"look_at\": [1, 2, 0], "
             "\"view_degrees\": 60}");
    ASSERT_TRUE(soup.camera);
    EXPECT_EQ(soup.camera->eye, Vec3(2, 4, 6));
    EXPECT_EQ(soup.camera->towards, Vec3(0, 0, -1));
    EXPECT_EQ(soup.camera->up, Vec3(0, 1, 0));
    EXPECT_NEAR(soup.camera->view_angle, std::numbers::pi / 3.0, 1e-15);
    EXPECT_THAT(refused_with("\"camera\": {\"eye\": [0, 0, 1], \"look_at\": [0, 0, 0], \"up\": [0, 0, 1]}"),
                HasSubstr("straight along"));
    const PolygonSoup plan = with("\"camera\": {\"eye\": [0, 0, 1], \"look_at\": [0, 0, 0]}"); // any side may be up
    ASSERT_TRUE(plan.camera);
    EXPECT_NEAR(plan.camera->up.norm(), 1.0, 1e-15);
    EXPECT_NEAR(plan.camera->up.dot(plan.camera->towards), 0.0, 1e-15);
    EXPECT_THAT(refused_with("\"camera\": {\"eye\": [0, 0, 1]}"), HasSubstr("either \"towards\" or \"look_at\""));
    EXPECT_THAT(refused_with("\"camera\": {\"eye\": [0, 0, 1], \"look_at\": [0, 0, 1]}"),
                HasSubstr("position from which"));
}

} // namespace
} // namespace difusa::scene_file_lights_test
