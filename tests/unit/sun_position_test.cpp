#include <difusa/scene/sun_position.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <string>

namespace difusa::sun_position_test {
namespace {

constexpr double degree = std::numbers::pi / 180.0;

/// Meeus, chapter 7.
TEST(SunPosition, JulianDaysAreThePublishedOnes) {
    EXPECT_EQ(julian_day({2000, 1, 1}, 12.0), 2451545.0);
    EXPECT_EQ(julian_day({1999, 1, 1}, 0.0), 2451179.5);
    EXPECT_EQ(julian_day({1987, 1, 27}, 0.0), 2446822.5);
    EXPECT_EQ(julian_day({1987, 6, 19}, 12.0), 2446966.0);
    EXPECT_EQ(julian_day({1988, 1, 27}, 0.0), 2447187.5);
    EXPECT_EQ(julian_day({1900, 1, 1}, 0.0), 2415020.5);
    EXPECT_NEAR(julian_day({1957, 10, 4}, 0.81 * 24.0), 2436116.31, 1e-9);
    EXPECT_EQ(julian_day({2020, 2, 29}, 30.0), julian_day({2020, 3, 1}, 6.0));
}

TEST(SunPosition, KnowsTheCalendar) {
    EXPECT_TRUE(is_sound(Date{2000, 2, 29}));
    EXPECT_FALSE(is_sound(Date{1900, 2, 29}));
    EXPECT_FALSE(is_sound(Date{2023, 2, 29}));
    EXPECT_FALSE(is_sound(Date{2023, 4, 31}));
    EXPECT_FALSE(is_sound(Date{2023, 13, 1}));
    EXPECT_FALSE(is_sound(Date{2023, 1, 0}));
    EXPECT_FALSE(is_sound(Date{1899, 1, 1}));
}

/// Meeus, example 25.a: 1992 October 13, 0h dynamical time, to the digits in print.
TEST(SunPosition, CoordinatesAreThoseOfThePublishedExample) {
    const SunCoordinates sun = sun_coordinates(2448908.5);
    EXPECT_NEAR(sun.longitude, 199.90895, 1e-5);
    EXPECT_NEAR(sun.distance, 0.99766, 1e-5);
    EXPECT_NEAR(sun.right_ascension, 198.38083, 1e-5);
    EXPECT_NEAR(sun.declination, -7.78507, 1e-5);
    // The same by the full theory (example 25.b).
    EXPECT_NEAR(sun.right_ascension, 198.378178, 0.01);
    EXPECT_NEAR(sun.declination, -7.783871, 0.01);
}

/// Meeus, examples 12.a and 12.b: 1987 April 10, 0h and 19h 21m universal time.
TEST(SunPosition, SiderealTimeIsThatOfThePublishedExamples) {
    EXPECT_NEAR(sidereal_time(julian_day({1987, 4, 10}, 0.0)), 197.693195, 1e-6);
    EXPECT_NEAR(sidereal_time(julian_day({1987, 4, 10}, 19.0 + 21.0 / 60.0)), 128.7378734, 1e-6);
}

/// Equinoxes and solstices as published by the United States Naval Observatory, in universal time: there the sun's
/// longitude is a multiple of 90°. In the minute of rounding it moves 0.0007°.
TEST(SunPosition, EquinoxesAndSolsticesAreThePublishedOnes) {
    struct Season {
        Date date;
        double hour, minute, longitude;
    };
    constexpr std::array<Season, 12> table{{{{2000, 3, 20}, 7, 35, 0},
                                            {{2000, 6, 21}, 1, 48, 90},
                                            {{2000, 9, 22}, 17, 28, 180},
                                            {{2000, 12, 21}, 13, 37, 270},
                                            {{2010, 3, 20}, 17, 32, 0},
                                            {{2010, 6, 21}, 11, 28, 90},
                                            {{2010, 9, 23}, 3, 9, 180},
                                            {{2010, 12, 21}, 23, 38, 270},
                                            {{2020, 3, 20}, 3, 50, 0},
                                            {{2020, 6, 20}, 21, 44, 90},
                                            {{2020, 9, 22}, 13, 31, 180},
                                            {{2020, 12, 21}, 10, 2, 270}}};
    for (const Season& season : table) {
        const double day = julian_day(season.date, season.hour + season.minute / 60.0) + 66.0 / 86400.0;
        const double miss = std::remainder(sun_coordinates(day).longitude - season.longitude, 360.0);
        EXPECT_NEAR(miss, 0.0, 0.01) << season.date.year << "-" << season.date.month;
    }
}

/// The example of I. Reda and A. Andreas, "Solar position algorithm for solar radiation applications",
/// NREL/TP-560-34302 (2008), table A5.1, whose own error is below 0.0003°.
TEST(SunPosition, IsThatOfTheReferenceAlgorithm) {
    const double day = julian_day({2003, 10, 17}, 12.5 + 30.0 / 3600.0 + 7.0);
    EXPECT_NEAR(day, 2452930.312847, 1e-6);
    const SunPosition sun = sun_position(day, 39.742476, -105.1786, {820.0, 11.0});
    EXPECT_NEAR(sun.azimuth, 194.34024, 0.01);
    EXPECT_NEAR(sun.elevation, 90.0 - 50.11162, 0.01);
    EXPECT_NEAR(sun.distance, 0.9965422974, 1e-4);
    const SunCoordinates seen = sun_coordinates(day + 67.0 / 86400.0);
    EXPECT_NEAR(seen.longitude, 204.0085519281, 0.01);
    EXPECT_NEAR(seen.right_ascension, 202.22741, 0.01);
    EXPECT_NEAR(seen.declination, -9.31434, 0.01);
}

TEST(SunPosition, DirectionsFollowTheCompass) {
    const Vec3 up = Vec3::UnitZ(), north(0.0, 2.0, 5.0); // only its level part counts
    const auto expect = [&](double azimuth, double elevation, const Vec3& wanted) {
        EXPECT_LE((towards_sun({azimuth, elevation}, up, north) - wanted).norm(), 1e-15) << azimuth;
    };
    expect(0.0, 0.0, Vec3::UnitY());
    expect(90.0, 0.0, Vec3::UnitX());
    expect(180.0, 0.0, -Vec3::UnitY());
    expect(270.0, 0.0, -Vec3::UnitX());
    expect(123.0, 90.0, up);
    expect(90.0, 30.0, Vec3(std::cos(30.0 * degree), 0.0, 0.5));
}

TEST(SunPosition, IsHighestInTheSouthAtNoonAndTheSameEastAndWest) {
    // A turn of the earth later or earlier the sun stands 15° an hour east or west.
    const double day = julian_day({2024, 6, 20}, 12.0);
    const SunPosition here = sun_position(day, 48.0, 10.0), there = sun_position(day - 2.0 / 24.0, 48.0, 40.0);
    EXPECT_NEAR(here.azimuth, there.azimuth, 0.01);
    EXPECT_NEAR(here.elevation, there.elevation, 0.01);
    double highest = -90.0, at = 0.0;
    for (double hours = 0.0; hours < 24.0; hours += 0.01) {
        const SunPosition sun = sun_position(julian_day({2024, 6, 20}, hours), 48.0, 0.0);
        if (sun.elevation > highest) {
            highest = sun.elevation;
            at = sun.azimuth;
        }
    }
    EXPECT_NEAR(highest, 90.0 - 48.0 + 23.44, 0.03); // refraction 0.007°, parallax, a day before or after
    EXPECT_NEAR(at, 180.0, 0.5);
}

TEST(SunPosition, AClearSkyLeavesWhatThePublishedFormulasSay) {
    EXPECT_EQ(clear_sky_sun({180.0, -0.1, 1.0}), 0.0);
    EXPECT_EQ(clear_sky_sun({180.0, 0.0, 1.0}), 0.0);
    // Air mass 1 at the zenith (Kasten and Young: 0.9997), 37.9 at the horizon.
    EXPECT_NEAR(clear_sky_sun({180.0, 90.0, 1.0}), 0.7 * 1361.0, 0.2);
    EXPECT_NEAR(clear_sky_sun({180.0, 90.0, 2.0}), 0.7 * 1361.0 / 4.0, 0.1);
    EXPECT_EQ(clear_sky_sunlight({180.0, 0.0, 1.0}), 0.0);
    // Overhead the air mass is 1 to 3e-4.
    EXPECT_NEAR(683.0 * clear_sky_sunlight({180.0, 90.0, 1.0}), 127500.0 * std::exp(-0.21), 10.0);
    // At 30° it is 1.994 (Kasten and Young).
    EXPECT_NEAR(683.0 * clear_sky_sunlight({180.0, 30.0, 1.0}), 127500.0 * std::exp(-0.21 * 1.994), 30.0);
    EXPECT_NEAR(683.0 * clear_sky_sunlight({180.0, 90.0, 2.0}), 127500.0 * std::exp(-0.21) / 4.0, 3.0);
    EXPECT_NEAR(clear_sky_sun({180.0, 1e-9, 1.0}), 1361.0 * std::pow(0.7, std::pow(37.92, 0.678)), 0.05);
}

} // namespace
} // namespace difusa::sun_position_test
