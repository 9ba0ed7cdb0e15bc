// What sensors in mid-air measure of a field.
#pragma once

#include <difusa/radiosity/error_map.h>
#include <difusa/radiosity/field.h>

#include <cstdint>
#include <span>
#include <vector>

namespace difusa {

/// What a sensor measures of the radiance L(w) that arrives at its place from the unit directions w; its axis is the
/// unit vector a:
///   planar       the irradiance of a plane with the normal a:           integral of L max(0, w.a) dw
///   spherical    the mean irradiance of the surface of a small sphere:  1/4 of the integral of L dw
///   cylindrical  the mean irradiance of the side of a small cylinder around a:  1/pi of the integral of L |w x a| dw
/// (CIE S 017, "mean spherical" and "mean cylindrical" illuminance.)
enum class SensorKind { planar, spherical, cylindrical };

struct Sensor {
    Vec3 position = Vec3::Zero();
    Vec3 axis = Vec3::UnitZ();
    SensorKind kind = SensorKind::planar;
};

/// #sensors by 3, W/m². A grey scene has three equal columns.
struct SensorReadings {
    Values H, H_direct, H_indirect;
    std::vector<GroupValues> groups; ///< H of each; no B. Empty if all light is one set
    Values noise;                    ///< #sensors by 1: estimated noise of H, root mean square over the channels
    Values error;                    ///< likewise: noise, and the error of the light on the surfaces that are seen; no
                                     ///< rows without an error map
    std::size_t rays = 0, segments = 0; ///< cast
};

constexpr std::size_t least_sensor_rays = 4;

/// Rays of each sensor: about `first` (at least least_sensor_rays), and up to `most` where they are noisy.
struct SensorRays {
    std::size_t first, most;
    SensorRays(std::size_t rays) : SensorRays(rays, rays) {}
    SensorRays(std::size_t first, std::size_t most) : first(first), most(most) {}
};

/// Gathers the light at each sensor with fresh rays, in four independent parts whose scatter, and the light that single
/// rays bring, give the noise (gathering_noise.h); suns, point lights and area lights are evaluated as on surfaces. If
/// the noise of sensors, 1024 at a time, is above 2 % (root mean square), all of these are read again, with as many
/// more rays as it needs, but 2^24 in all, or four times as many as before if that is more. Few sensors take the most
/// rays at once. Spherical and cylindrical sensors are means over planar ones, randomly turned: 4 times 128 all around,
/// 4 times 32 around the axis.
///
/// Errors: an error of the light where a sensor's rays end adds to its own in proportion to the share of the rays. What
/// bounces carry on is taken to have one sign all around; what is local (noise and discretisation) to have one sign
/// over a surfel, and to be independent from one surfel to the next, as 64 probes find them. Throws UsageError for
/// fewer rays, and for sensors without a finite position or with an axis that is not of unit length.
SensorReadings read_sensors(const Field& field, std::span<const Sensor> sensors, const SensorRays& rays,
                            const ErrorMap* errors, std::uint64_t seed, const Execution& execution);

} // namespace difusa
