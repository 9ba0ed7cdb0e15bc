// The places at which a user wants to know the light: points of the surface, sensors in mid-air, grids of sensors.
#pragma once

#include <difusa/bake/result.h>

namespace difusa {

/// Clears Mesh::convex if a sensor is to be placed behind a face of a surface that is open: beyond the rim of a
/// courtyard, say, or above a sheet with two sides, from where faces hide others. To be called once it is settled which
/// sides are fronts. Throws UsageError for grids that cannot be placed.
void open_if_seen_from_outside(BakeResult& result);

/// Fills in `listed`, `listed_distance`, `listed_number` and `sensors`. A place without a normal, or with BakeOptions::
/// snap, is the nearest point of the surface; so is one with a normal on the surface that faces this way, to within
/// rounding. All others are sensors: planar ones with the place's normal, or, as BakeOptions::sensor says, horizontal
/// (planar, facing up), spherical, or cylindrical around the vertical. Notes places that are far from the surface
/// although a surface point was asked for. Throws InputError for a normal that no surface has, a sensor behind the
/// surface of a closed convex room, a grid on nothing, on a face that is not flat, or with more than a million sensors,
/// and UsageError for a normal that a sensor without one has no use for.
void find_places(BakeResult& result, const Execution& execution);

/// Notes how many points no element reaches, whose light Field::at has gathered; nothing after a final gather.
void note_gathered(const BakeResult& result, const PointValues& values, const char* thing, const Execution& execution);

/// Fills in `listed_values` and `readings`. `errors`: null without an estimate.
void read_places(BakeResult& result, const ErrorMap* errors, const Execution& execution);

/// What a grid comes to, as lighting standards ask for it: in lux of a photometric bake, else in W/m², the mean of the
/// channels weighted by their luminance (core/colour.h).
struct GridSummary {
    std::size_t count = 0;
    double least = 0.0, mean = 0.0, most = 0.0;
    double uniformity = 0.0; ///< least / mean; 0 where all is dark
    double error = 0.0;      ///< root mean square of the estimated errors of the sensors; 0 without an estimate
};

GridSummary summary_of_grid(const BakeResult& result, std::size_t grid);

} // namespace difusa
