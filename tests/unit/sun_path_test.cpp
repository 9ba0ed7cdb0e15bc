#include <difusa/bake/sun_path.h>
#include <difusa/core/error.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace difusa::sun_path_test {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

SunPath summer() {
    SunPath path;
    path.latitude = 48.0;
    path.longitude = 15.0;
    path.date = {2025, 6, 21};
    path.time_zone = 1.0;
    path.step = 0.5;
    return path;
}

TEST(SunPath, HasTheTimesAtWhichTheSunIsUp) {
    const std::vector<SunStep> steps = sun_steps(summer(), Vec3::UnitZ());
    ASSERT_FALSE(steps.empty());
    const auto elevation = [](double hours) {
        return sun_position(julian_day({2025, 6, 21}, hours - 1.0), 48.0, 15.0).elevation;
    };
    EXPECT_LE(elevation(steps.front().hours - 0.5), 0.0);
    EXPECT_LE(elevation(steps.back().hours + 0.5), 0.0);
    for (std::size_t i = 0; i < steps.size(); ++i) {
        EXPECT_EQ(steps[i].hours, steps.front().hours + 0.5 * static_cast<double>(i));
        EXPECT_GT(steps[i].position.elevation, 0.0);
        EXPECT_NEAR(steps[i].sun.towards.norm(), 1.0, 1e-15);
        EXPECT_NEAR(std::asin(steps[i].sun.towards.z()), steps[i].position.elevation * M_PI / 180.0, 1e-12);
        EXPECT_EQ(steps[i].sun.irradiance[1], clear_sky_sun(steps[i].position));
        if (steps[i].hours != 12.0) { // on the central meridian of its time zone: noon but for two minutes
            const bool morning = steps[i].hours<12.0, east = steps[i].sun.towards.x()> 0.0;
            EXPECT_EQ(morning, east);
        }
    }
}

TEST(SunPath, EndsIncludeTheLastTime) {
    SunPath path = summer();
    path.from = 10.0;
    path.to = 12.0;
    path.step = 0.1;
    EXPECT_EQ(sun_steps(path, Vec3::UnitZ()).size(), 21U);
    path.to = path.from;
    EXPECT_EQ(sun_steps(path, Vec3::UnitZ()).size(), 1U);
}

TEST(SunPath, NorthAndUpTurnTheSun) {
    const std::vector<SunStep> z_up = sun_steps(summer(), Vec3::UnitZ()), y_up = sun_steps(summer(), Vec3::UnitY());
    SunPath turned = summer();
    turned.north = Vec3::UnitX();
    const std::vector<SunStep> x_north = sun_steps(turned, Vec3::UnitZ());
    for (std::size_t i = 0; i < z_up.size(); ++i) {
        const Vec3 s = z_up[i].sun.towards; // east, north, up
        EXPECT_LE((y_up[i].sun.towards - Vec3(s.x(), s.z(), -s.y())).norm(), 1e-15);
        EXPECT_LE((x_north[i].sun.towards - Vec3(s.y(), -s.x(), s.z())).norm(), 1e-15);
    }
}

TEST(SunPath, StrengthIsThatWhichIsGiven) {
    SunPath path = summer();
    path.strength = Rgb(3, 2, 1);
    for (const SunStep& step : sun_steps(path, Vec3::UnitZ())) {
        EXPECT_TRUE((step.sun.irradiance == Rgb(3, 2, 1)).all());
    }
}

TEST(SunPath, RefusesWhatThereIsNot) {
    const auto refused = [](const std::string& what, const auto& change) {
        SunPath path = summer();
        change(path);
        EXPECT_THAT([&] { sun_steps(path, Vec3::UnitZ()); }, ThrowsMessage<UsageError>(HasSubstr(what)));
    };
    refused("latitude", [](SunPath& path) { path.latitude = 90.5; });
    refused("longitude", [](SunPath& path) { path.longitude = -181.0; });
    refused("no such day", [](SunPath& path) { path.date = {2025, 2, 29}; });
    refused("--time-zone", [](SunPath& path) { path.time_zone = NAN; });
    refused("--hours", [](SunPath& path) { path.from = 13.0, path.to = 12.0; });
    refused("--hours", [](SunPath& path) { path.to = 24.5; });
    refused("step", [](SunPath& path) { path.step = 0.0; });
    refused("step", [](SunPath& path) { path.step = 0.001; });
    refused("--sun-strength", [](SunPath& path) { path.strength = Rgb::Zero(); });
    refused("--north", [](SunPath& path) { path.north = Vec3::UnitZ(); });
    refused("below the horizon", [](SunPath& path) { path.to = 1.0; });
    refused("below the horizon", [](SunPath& path) { path.latitude = 80.0, path.date = {2025, 12, 21}; });
}

} // namespace
} // namespace difusa::sun_path_test
