// Where the sun stands, by the method of J. Meeus, "Astronomical Algorithms" (2nd ed. 1998), chapters 7, 12, 13 and 25,
// "low accuracy": 0.01° of the sun's longitude. Angles in degrees.
#pragma once

#include <difusa/core/types.h>

namespace difusa {

/// A day of the Gregorian calendar.
struct Date {
    int year = 2000, month = 1, day = 1;
};

/// True if there is such a day, of a year from 1900 to 2100.
bool is_sound(const Date& date);

/// The Julian day at `hours` after midnight, universal time; hours may be negative or above 24.
double julian_day(const Date& date, double hours);

/// The sun as seen from the centre of the earth.
struct SunCoordinates {
    double longitude = 0.0; ///< apparent, on the ecliptic
    double right_ascension = 0.0, declination = 0.0;
    double distance = 1.0; ///< astronomical units
};

/// `day`: the Julian day in dynamical time.
SunCoordinates sun_coordinates(double day);

/// Mean sidereal time in Greenwich; `day`: the Julian day in universal time.
double sidereal_time(double day);

/// The air that bends the light of a low sun.
struct Air {
    double pressure = 1010.0;  ///< millibar; 0: no refraction
    double temperature = 10.0; ///< °C
};

/// The sun as seen from a place.
struct SunPosition {
    double azimuth = 0.0; ///< from north over east, in [0, 360)
    double elevation =
        0.0;               ///< above the horizon, with refraction (Saemundsson's formula) where the sun is not below it
    double distance = 1.0; ///< astronomical units
};

/// `day`: the Julian day in universal time; `latitude`: north; `longitude`: east. Dynamical time is taken from the
/// polynomial of Espenak and Meeus (2006) for 2005 to 2050: an error of a minute turns the sun by 0.0007°.
SunPosition sun_position(double day, double latitude, double longitude, const Air& air = {});

/// Where north is if nobody says so: +y where z is up, else -z.
Vec3 default_north(const Vec3& up);

/// The unit vector towards the sun; `up` is unit, `north` any direction that is not vertical.
Vec3 towards_sun(const SunPosition& position, const Vec3& up, const Vec3& north);

/// Irradiance of a surface that faces the sun under a clear sky, W/m²: 1361 / distance² times 0.7 to the power m^0.678
/// (A. and M. Meinel, "Applied Solar Energy", 1976) for the relative air mass m (Kasten and Young 1989); 0 if the sun
/// is not above the horizon.
double clear_sky_sun(const SunPosition& position);

/// The same of its light alone, W/m² of 683 lm/W each: 127.5 klx / distance² times exp(-0.21 m) for the same m (clear
/// sky of the Illuminating Engineering Society of North America, "Recommended practice for the calculation of daylight
/// availability", 1984). Only about a seventh of the sun's power counts as light in these units.
double clear_sky_sunlight(const SunPosition& position);

} // namespace difusa
