#include <difusa/scene/sun_position.h>

#include <difusa/core/photometry.h>

#include <cmath>
#include <numbers>

namespace difusa {

namespace {

constexpr double degree = std::numbers::pi / 180.0;

double sin_of(double degrees) {
    return std::sin(degrees * degree);
}

double cos_of(double degrees) {
    return std::cos(degrees * degree);
}

/// In [0, 360).
double full_turn(double degrees) {
    const double rest = std::fmod(degrees, 360.0);
    return rest < 0.0 ? rest + 360.0 : rest;
}

/// Julian centuries since 2000 January 1.5.
double centuries(double day) {
    return (day - 2451545.0) / 36525.0;
}

/// The sum of c[k] x^k.
template <class... C> double polynomial(double x, double first, C... rest) {
    if constexpr (sizeof...(rest) == 0) {
        return first;
    } else {
        return first + x * polynomial(x, rest...);
    }
}

/// Longitude of the ascending node of the moon's mean orbit, on which nutation depends.
double lunar_node(double T) {
    return polynomial(T, 125.04, -1934.136);
}

/// Nutation in longitude, its largest term.
double nutation(double T) {
    return -0.00478 * sin_of(lunar_node(T));
}

double obliquity(double T) {
    return polynomial(T, 23.4392911, -0.0130042, -1.64e-7, 5.04e-7) + 0.00256 * cos_of(lunar_node(T));
}

/// Dynamical minus universal time, in days.
double delta_t(double day) {
    const double years = (day - 2451544.5) / 365.25;
    return polynomial(years, 62.92, 0.32217, 0.005589) / 86400.0;
}

/// By which refraction lifts the sun; nothing once all of it is below the horizon.
double refraction(double elevation, const Air& air) {
    constexpr double disc = 0.26667, at_horizon = 0.5667; // half the sun's diameter; refraction there
    if (elevation < -(disc + at_horizon)) {
        return 0.0;
    }
    const double bent = 1.02 / (60.0 * std::tan((elevation + 10.3 / (elevation + 5.11)) * degree));
    return air.pressure / 1010.0 * 283.0 / (273.0 + air.temperature) * bent;
}

} // namespace

bool is_sound(const Date& date) {
    constexpr int days[] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
    if (date.year < 1900 || date.year > 2100 || date.month < 1 || date.month > 12 || date.day < 1) {
        return false;
    }
    const bool leap = date.year % 4 == 0 && (date.year % 100 != 0 || date.year % 400 == 0);
    return date.day <= days[date.month - 1] + (leap && date.month == 2 ? 1 : 0);
}

double julian_day(const Date& date, double hours) {
    // January and February are months 13 and 14 of the year before.
    const int year = date.month <= 2 ? date.year - 1 : date.year,
              month = date.month <= 2 ? date.month + 12 : date.month;
    const int century = year / 100, gregorian = 2 - century + century / 4;
    return std::floor(365.25 * (year + 4716)) + std::floor(30.6001 * (month + 1)) + date.day + gregorian - 1524.5 +
           hours / 24.0;
}

SunCoordinates sun_coordinates(double day) {
    const double T = centuries(day);
    const double L0 = polynomial(T, 280.46646, 36000.76983, 0.0003032);       // mean longitude
    const double M = polynomial(T, 357.52911, 35999.05029, -0.0001537);       // mean anomaly
    const double e = polynomial(T, 0.016708634, -0.000042037, -0.0000001267); // eccentricity of the orbit
    const double C = polynomial(T, 1.914602, -0.004817, -0.000014) * sin_of(M) +
                     polynomial(T, 0.019993, -0.000101) * sin_of(2.0 * M) + 0.000289 * sin_of(3.0 * M);
    constexpr double aberration = -0.00569;
    SunCoordinates sun;
    sun.longitude = full_turn(L0 + C + aberration + nutation(T));
    sun.distance = 1.000001018 * (1.0 - e * e) / (1.0 + e * cos_of(M + C));
    const double epsilon = obliquity(T), lambda = sun.longitude;
    sun.right_ascension = full_turn(std::atan2(cos_of(epsilon) * sin_of(lambda), cos_of(lambda)) / degree);
    sun.declination = std::asin(sin_of(epsilon) * sin_of(lambda)) / degree;
    return sun;
}

double sidereal_time(double day) {
    const double T = centuries(day);
    return full_turn(280.46061837 + 360.98564736629 * (day - 2451545.0) + T * T * (0.000387933 - T / 38710000.0));
}

SunPosition sun_position(double day, double latitude, double longitude, const Air& air) {
    const double dynamical = day + delta_t(day), T = centuries(dynamical);
    const SunCoordinates sun = sun_coordinates(dynamical);
    const double apparent = sidereal_time(day) + nutation(T) * cos_of(obliquity(T));
    const double H = apparent + longitude - sun.right_ascension; // hour angle
    const double phi = latitude, delta = sun.declination;
    SunPosition seen;
    seen.distance = sun.distance;
    seen.azimuth = full_turn(
        180.0 + std::atan2(sin_of(H), cos_of(H) * sin_of(phi) - sin_of(delta) / cos_of(delta) * cos_of(phi)) / degree);
    const double geocentric = std::asin(sin_of(phi) * sin_of(delta) + cos_of(phi) * cos_of(delta) * cos_of(H)) / degree;
    constexpr double parallax = 8.794 / 3600.0; // the radius of the earth, as seen from the sun
    const double elevation = geocentric - parallax / sun.distance * cos_of(geocentric);
    seen.elevation = elevation + refraction(elevation, air);
    return seen;
}

Vec3 default_north(const Vec3& up) {
    return std::abs(up.z()) > 0.5 ? Vec3(Vec3::UnitY()) : Vec3(-Vec3::UnitZ());
}

Vec3 towards_sun(const SunPosition& position, const Vec3& up, const Vec3& north) {
    const Vec3 ahead = (north - north.dot(up) * up).normalized(), east = ahead.cross(up);
    return cos_of(position.elevation) * (cos_of(position.azimuth) * ahead + sin_of(position.azimuth) * east) +
           sin_of(position.elevation) * up;
}

namespace {

/// Relative air mass at an elevation above 0 (Kasten and Young 1989).
double air_mass(double h) {
    return 1.0 / (sin_of(h) + 0.50572 * std::pow(h + 6.07995, -1.6364));
}

} // namespace

double clear_sky_sun(const SunPosition& position) {
    if (!(position.elevation > 0.0)) {
        return 0.0;
    }
    constexpr double solar_constant = 1361.0;
    return solar_constant / (position.distance * position.distance) *
           std::pow(0.7, std::pow(air_mass(position.elevation), 0.678));
}

double clear_sky_sunlight(const SunPosition& position) {
    if (!(position.elevation > 0.0)) {
        return 0.0;
    }
    constexpr double solar_illuminance = 127500.0;
    return solar_illuminance / lumens_per_watt / (position.distance * position.distance) *
           std::exp(-0.21 * air_mass(position.elevation));
}

} // namespace difusa
