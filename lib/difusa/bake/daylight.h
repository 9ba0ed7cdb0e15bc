// Daylight coefficients of a bake's places, and skies in the parts that they are made for.
#pragma once

#include <difusa/bake/result.h>
#include <difusa/radiosity/daylight.h>
#include <difusa/scene/sky_division.h>

#include <optional>
#include <string>
#include <vector>

namespace difusa {

/// What is wanted of them.
struct DaylightRequest {
    int factor = 1;            ///< SkyDivision: 1 for Tregenza's parts, 2 for 577, 4 for 2305, and the ground
    std::optional<Vec3> north; ///< absent: default_north (bake/sun_path.h)
    std::size_t rays = 2048;   ///< from each place, about
};

struct DaylightMatrix {
    SkyDivision sky;
    std::vector<SurfacePoint> points; ///< places in the order of their list, then the sensors of grids; without any,
                                      ///< the vertices of the output mesh
    DaylightCoefficients coefficients;
};

/// Of a result that has a system and a solution; without places, its output mesh is refined if it is not there. Throws
/// UsageError for a thermal scene, for sensors that are not planar, and ResourceError if the matrix does not fit into
/// memory.
DaylightMatrix daylight_matrix(BakeResult& result, const DaylightRequest& request, const Execution& execution);

/// A sky as a user chooses it, over the parts.
struct SkyInParts {
    Values radiance;                ///< #parts by 3, W/(m² sr)
    std::string text;               ///< the choice with all parameters
    std::vector<std::string> notes; ///< what was left out or assumed
};

/// "cie:type=12,elevation=40,azimuth=180,illuminance=10000" (types 1 to 16; or diffuse, in W/m²) or
/// "perez:direct=700,diffuse=100,elevation=40,azimuth=180,dew=11,sun=part,light=visible". Radiances are means over the
/// parts, scaled so that they give level ground exactly the diffuse irradiance. `ground`: the reflectance of the
/// ground, which is as bright as sky and sun make it. `sun=part` spreads the light of the sun over the part that it is
/// in. `light=visible`: watts of which lumens_per_watt lumens are made (core/photometry.h), by the model's efficacies;
/// `solar`: those of the whole spectrum. Throws UsageError.
SkyInParts sky_in_parts(const std::string& choice, const SkyDivision& sky);

} // namespace difusa
