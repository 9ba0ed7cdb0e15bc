#include <difusa/bake/sun_path.h>

#include <difusa/bake/options.h>
#include <difusa/core/error.h>
#include <difusa/scene/sound_scene.h>

#include <cmath>
#include <string>
#include <utility>

namespace difusa {

namespace {

void check_path(const SunPath& path) {
    const auto refuse = [](const char* option, const char* why) { throw UsageError(std::string(option) + ": " + why); };
    if (!(std::abs(path.latitude) <= 90.0) || !(std::abs(path.longitude) <= 180.0)) {
        refuse("--sun-path", "the latitude must be from -90 to 90, and the longitude from -180 to 180 degrees");
    }
    if (!is_sound(path.date)) {
        refuse("--sun-path", "there is no such day, or it is not from 1900 to 2100");
    }
    if (!(std::abs(path.time_zone) <= 15.0)) {
        refuse("--time-zone", "must be from -15 to 15 hours");
    }
    if (!(path.from >= 0.0 && path.from <= path.to && path.to <= 24.0)) {
        refuse("--hours", "must be from 0 to 24, the first not after the last");
    }
    if (!(path.step > 0.0) || (path.to - path.from) / path.step >= static_cast<double>(most_sun_steps)) {
        refuse("--sun-path", "the step must be above 0, and there may be at most 10000 of them");
    }
    if (path.strength && (!is_light(*path.strength) || !(*path.strength > 0.0).any())) {
        refuse("--sun-strength", "must be finite, not negative, and not 0");
    }
}

} // namespace

std::vector<SunStep> sun_steps(const SunPath& path, const Vec3& up) {
    check_path(path);
    const Vec3 north = path.north.value_or(default_north(up));
    if (!(north.cross(up).norm() > 1e-6 * north.norm())) {
        throw UsageError("--north: must not be vertical");
    }
    std::vector<SunStep> steps;
    const double rounding = 1e-9 * path.step;
    for (std::size_t i = 0; path.from + static_cast<double>(i) * path.step <= path.to + rounding; ++i) {
        SunStep step;
        step.hours = path.from + static_cast<double>(i) * path.step;
        step.position = sun_position(julian_day(path.date, step.hours - path.time_zone), path.latitude, path.longitude);
        if (!(step.position.elevation > 0.0)) {
            continue;
        }
        step.sun.towards = towards_sun(step.position, up, north).normalized();
        step.sun.irradiance = path.strength.value_or(
            Rgb::Constant(path.photometric ? clear_sky_sunlight(step.position) : clear_sky_sun(step.position)));
        steps.push_back(std::move(step));
    }
    if (steps.empty()) {
        throw UsageError("--sun-path: the sun is below the horizon at all of these times; choose others, --hours, "
                         "and see that --time-zone is that of the place");
    }
    return steps;
}

} // namespace difusa
