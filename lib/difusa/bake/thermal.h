// Thermal scenes: what is refused, temperatures that are solved for, and the balance of heat.
#pragma once

#include <difusa/bake/result.h>

#include <vector>

namespace difusa {

/// Makes the scene of the result a thermal one (scene/thermal.h). Throws InputError as settle_thermal does, and
/// UsageError for options that ask for light.
void make_thermal(BakeResult& result, const Execution& execution);

/// Throws UsageError if a place of a thermal scene is a sensor.
void check_places(const BakeResult& result);

/// Without surroundings nothing may leave the surface: throws InputError if more than a thousandth of the radiation
/// does, or ends on backs; notes what little is lost, and what ends on backs.
void check_surroundings(const BakeResult& result, const SiteSet& sites, const LightTransport& transport,
                        const Execution& execution);

/// Finds the temperatures of the materials whose heat is prescribed: their light and that of everything else are solved
/// for as sets, and a small linear system says how warm each has to be. Does nothing if there are none. Throws
/// InputError if one of them exchanges no heat, or would have to be colder than 0 K.
void find_temperatures(BakeResult& result, const LightingOptions& options, const Execution& execution);

/// Fills in `thermal` from `output`, `centres`, `errors` and the solution. Throws InputError where more heat is drawn
/// from a surface than arrives.
void evaluate_thermal(BakeResult& result, const Execution& execution);

/// The state of points of these materials at these places, with the irradiance H that the scene is solved for (its
/// first column). Throws InputError where more heat is drawn than arrives.
ThermalValues thermal_values(const BakeResult& result, const Values& H, const std::vector<Index>& material,
                             const std::vector<Vec3>& place);

/// The irradiance of the surfels, means, by the channels of each set: #surfels by #columns of h.
Values surfel_irradiance(const Solution& solution, const Execution& execution);

} // namespace difusa
