// Daylight coefficients: the irradiance that each part of the sky causes at points, all reflections included
// (P. Tregenza and I. Waters, "Daylight coefficients", Lighting Research and Technology 15(2), 1983).
#pragma once

#include <difusa/radiosity/system.h>
#include <difusa/scene/sky_division.h>

#include <cstdint>
#include <span>

namespace difusa {

struct DaylightOptions {
    /// Those of the rays that the system's transport was gathered with (BakeOptions::rays): the same rays are cast once
    /// more, and sorted by the parts of the division.
    std::size_t site_rays = 512;
    /// About so many rays from each of the points into the hemisphere above it; at least one into each part.
    std::size_t rays = 2048;
    std::uint64_t seed = 1;
    SolveOptions solve = {};
    std::size_t most_bytes = std::size_t{512} << 20U; ///< of the radiosities of the surfels that are in memory at once
};

/// Irradiance in W/m² for a radiance of 1 W/(m² sr), in sr.
struct DaylightCoefficients {
    int channels = 3;                    ///< 1: nothing that reflects has a colour
    Values value;                        ///< #points by #parts times `channels`, the channels of each part in turn
    std::size_t rays = 0, site_rays = 0; ///< cast

    /// The irradiance at the points under a sky whose parts have these radiances, W/(m² sr): #parts by 3; #points by 3.
    Values irradiance(const Values& radiance) const;
};

/// C = Y' + D' diag(rho) P Π' (I - T)⁻¹ Y: Y are the parts' shares of the rays from the gather points of the system,
/// and Y' and D' those of fresh rays from the points, one into each cell of about equal solid angle
/// (SkyDivision::cells). A cell that is all above the plane of a point counts with its exact projected solid angle, the
/// other ones so that all add up to pi: where nothing is in the way, coefficients of parts above the plane are exact,
/// and their sum is pi. Where the sky is seen through openings (rays/sky_openings.h), further rays are aimed at them,
/// in place of those that happen to escape there; the others are scaled so that all add up to pi. Columns are solved
/// for together. Rays on from mirrors are followed.
///
/// `x`: points of the surface, or sensors in mid-air; `reflectance`: of the surfels, #surfels by 1 or 3. The same bits
/// for any number of threads. Phases: "sky at the sites", "solve for the sky", "sky at the points".
DaylightCoefficients daylight_coefficients(const RadiositySystem& system, const Values& reflectance,
                                           std::span<const SurfacePoint> x, const SkyDivision& sky,
                                           const DaylightOptions& options, const Execution& execution);

} // namespace difusa
