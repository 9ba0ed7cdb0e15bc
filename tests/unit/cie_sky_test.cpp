// The general skies of the CIE, and the disc of the sun.
#include <difusa/lighting/direct_light.h>
#include <difusa/mesh/mesh.h>
#include <difusa/rays/brute_force.h>
#include <difusa/scene/cie_sky.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "scene_file_fixture.h"

namespace difusa::cie_sky_test {
namespace {

constexpr double pi = std::numbers::pi;
using test::SceneFile;

const Vec3 up = Vec3::UnitZ();

TEST(CieSky, UniformAndTraditionalOvercastAreExact) {
    const CieSky uniform(5, up, up), overcast(16, up, up);
    EXPECT_NEAR(uniform.relative(Vec3(0.6, 0, 0.8)), 1.0, 1e-15);
    EXPECT_NEAR(uniform.level_irradiance(), pi, 1e-9);
    EXPECT_NEAR(overcast.relative(Vec3(0.8, 0, 0.6)), 2.2 / 3.0, 1e-15);
    EXPECT_NEAR(overcast.level_irradiance(), 7.0 * pi / 9.0, 1e-9);
}

TEST(CieSky, EveryTypeIsOneAtTheZenithAndAsBrightAsOrdered) {
    const Vec3 sun = Vec3(1, -2, 1.5).normalized();
    for (int type = 1; type <= 16; ++type) {
        CieSky sky(type, up, sun);
        EXPECT_NEAR(sky.relative(up), 1.0, 1e-14) << type;
        sky.scale_to_irradiance(Rgb(3, 2, 1));
        double sum = 0.0; // by a midpoint rule in the square of the sine
        constexpr int n = 300;
        for (int i = 0; i < n; ++i) {
            for (int j = 0; j < n; ++j) {
                const double z = std::sqrt((i + 0.5) / n), r = std::sqrt(1.0 - z * z), a = 2.0 * pi * (j + 0.5) / n;
                sum += sky.radiance({r * std::cos(a), r * std::sin(a), z})[0];
            }
        }
        EXPECT_NEAR(sum * pi / (n * n), 3.0, 2e-3) << type;
        EXPECT_TRUE((sky.radiance(Vec3(0.6, 0, -0.8)) == 0.0).all());
    }
}

TEST(CieSky, TypeOneIsNearTheTraditionalOvercastSky) {
    const CieSky standard(1, up, up), traditional(16, up, up);
    // At the horizon 1 / (1 + 4 exp(-0.7)) = 0.335, and 1/3; in between, the standard sky is up to 0.07 darker.
    EXPECT_NEAR(standard.relative(Vec3::UnitX()), 1.0 / (1.0 + 4.0 * std::exp(-0.7)), 1e-14);
    EXPECT_NEAR(standard.relative(Vec3::UnitX()), 1.0 / 3.0, 0.002);
    for (const double z : {0.1, 0.3, 0.5, 0.7, 0.9}) {
        const Vec3 towards(std::sqrt(1.0 - z * z), 0, z);
        EXPECT_NEAR(standard.relative(towards), traditional.relative(towards), 0.07);
    }
}

TEST(CieSky, RefusesASunBelowTheHorizon) {
    EXPECT_THROW(CieSky(12, up, Vec3(1, 0, -1).normalized()), std::invalid_argument);
    EXPECT_THROW(CieSky(17, up, up), std::invalid_argument);
}

TEST_F(SceneFile, CieSkiesAndSunsByDate) {
    const PolygonSoup soup =
        with("\"sky\": {\"type\": \"cie\", \"sky\": 16, \"illuminance\": 6830, \"ground_reflectance\": 0.2},"
             "\"lights\": [{\"type\": \"sun\", \"latitude\": 48.14, \"longitude\": 11.58, \"date\": \"2026-06-21\","
             "\"time\": 13.25, \"time_zone\": 2, \"angular_diameter\": 0.533}]");
    ASSERT_TRUE(soup.lights.dome);
    EXPECT_NEAR(soup.lights.dome->radiance(up)[0], 10.0 * 9.0 / (7.0 * pi), 1e-9);
    EXPECT_NEAR(soup.lights.dome->radiance(-up)[0], 2.0 / pi, 1e-9);
    const Sun& sun = soup.lights.suns.at(0);
    // Close to noon at the solstice: 90 - 48.14 + 23.44 degrees, in the south.
    EXPECT_NEAR(std::asin(sun.towards.z()) * 180.0 / pi, 65.3, 0.1);
    EXPECT_LT(sun.towards.y(), -0.4);
    EXPECT_NEAR(sun.disc, std::sin(0.2665 * pi / 180.0), 1e-12);
    EXPECT_NE(refused_with("\"sky\": {\"type\": \"cie\", \"sky\": 12, \"illuminance\": 1}").find("\"sun\""),
              std::string::npos);
    for (const std::string sky : {"1", "12, \"sun\": [1, 0, 1]"}) { // a place and a time without a date
        EXPECT_NE(refused_with("\"sky\": {\"type\": \"cie\", \"illuminance\": 1, \"time\": 77, \"sky\": " + sky + "}")
                      .find("\"time\" places the sun together with a \"date\""),
                  std::string::npos);
    }
}

TEST_F(SceneFile, CieSkiesHaveNumbersAndNames) {
    const auto radiance = [&](const std::string& sky) {
        return with(R"("sky": {"type": "cie", "sky": )" + sky + R"(, "sun": [1, 0, 1], "illuminance": 1000})")
            .lights.dome->radiance(Vec3(0.6, 0.0, 0.8))[0];
    };
    for (const auto& [name, number] :
         {std::pair(R"("overcast")", "1"), std::pair(R"("uniform")", "5"), std::pair(R"("clear")", "12"),
          std::pair(R"("clear polluted")", "13"), std::pair(R"("traditional overcast")", "16")}) {
        EXPECT_EQ(radiance(name), radiance(number)) << name;
    }
    for (const char* const bad : {"0", "17", R"("cloudless")"}) {
        EXPECT_NE(refused_with(R"("sky": {"type": "cie", "sky": )" + std::string(bad) + R"(, "illuminance": 1})")
                      .find("1 to 15"),
                  std::string::npos);
    }
}

TEST(SunDisc, ThePenumbraOfAHalfPlaneIsACircularSegment) {
    // A floor, and a screen far larger than the penumbra 1 above it, with its edge at x = 0.
    Scene scene;
    Mesh& mesh = scene.mesh;
    mesh.points = {{-9, -9, 0}, {9, -9, 0}, {9, 9, 0}, {-9, 9, 0}, {-9, -9, 1}, {0, -9, 1}, {0, 9, 1}, {-9, 9, 1}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}};
    mesh.material = {0, 0, 0, 0};
    mesh.original_face = {0, 1, 2, 3};
    mesh.derive();
    scene.materials.resize(1);
    Sun sun{up, Rgb::Ones()};
    sun.disc = 0.1;
    scene.suns = {sun};
    BruteForceVisibility engine;
    engine.build(mesh);
    const DirectLight light(scene, Tracer(mesh, engine));
    DirectLight::Worker worker;
    for (const double at : {-0.2, -0.06, 0.0, 0.03, 0.08, 0.2}) {
        // A ray with the horizontal part s passes the screen at at + s / sqrt(1 - |s|²): the edge in the disc is at
        // s = -at to the second order of the disc's size.
        const double d = std::clamp(at / 0.1, -1.0, 1.0);
        const double seen = 1.0 - (std::acos(d) - d * std::sqrt(1.0 - d * d)) / pi;
        double mean = 0.0;
        constexpr std::size_t streams = 16;
        for (std::size_t s = 0; s < streams; ++s) {
            RandomStream stream(1, "penumbra", s);
            const SurfacePoint x = mesh.at(0, (at + 1.0) / 18.0, 4.0 / 9.0); // at (at, -1, 0)
            mean += light.irradiance(x, 256, stream, worker)[0] / streams;
        }
        EXPECT_NEAR(mean, seen, 0.004) << at; // the rounds stop at 0.002, and the edge bends by 0.5 %
    }
}

} // namespace
} // namespace difusa::cie_sky_test
