// The sun over a day at a place on earth.
#pragma once

#include <difusa/scene/lights.h>
#include <difusa/scene/sun_position.h>

#include <optional>
#include <vector>

namespace difusa {

struct SunPath {
    double latitude = 0.0, longitude = 0.0; ///< degrees, north and east
    Date date;
    double time_zone = 0.0;         ///< of all times, hours east of universal time
    double from = 0.0, to = 24.0;   ///< hours
    double step = 1.0;              ///< hours
    std::optional<Rgb> strength;    ///< irradiance of a surface that faces the sun, W/m²; absent: `clear_sky_sun`, or
                                    ///< if `photometric`, `clear_sky_sunlight`
    std::optional<Vec3> north = {}; ///< absent: default_north
    bool photometric = false;       ///< watts are those of light; relighting sets it as the lights of the scene are
};

/// The sun at one time of a path.
struct SunStep {
    double hours = 0.0; ///< in the path's time zone
    SunPosition position;
    Sun sun;
};

/// The largest number of steps of a path.
inline constexpr std::size_t most_sun_steps = 10000;

/// The times from, from + step, ... up to `to` at which the sun is above the horizon. `up`: unit. Throws UsageError for
/// a place, date, times or strength that there are not, a vertical north, more than `most_sun_steps` times, and if the
/// sun is below the horizon at all of them.
std::vector<SunStep> sun_steps(const SunPath& path, const Vec3& up);

} // namespace difusa
