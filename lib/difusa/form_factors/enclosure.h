// Radiative exchange between the surfaces of an enclosure, each of uniform radiosity, by their form factors: the net
// radiation method (H. C. Hottel; R. Siegel and J. R. Howell, "Thermal Radiation Heat Transfer").
#pragma once

#include <difusa/form_factors/form_factors.h>
#include <difusa/scene/scene.h>

#include <string>
#include <vector>

namespace difusa {

/// The state of a surface, and by how much the estimated errors of the form factors may change it at most, if all are
/// as large as estimated and add up.
struct EnclosureSurface {
    Index material = none;
    double area = 0.0;
    ThermalState state;
    double net_flux_error = 0.0;    ///< W/m²; 0 where it is prescribed
    double temperature_error = 0.0; ///< K; 0 where it is prescribed, and where it is 0
};

/// Heat in W, positive if it leaves the surfaces.
struct Enclosure {
    std::vector<EnclosureSurface> surfaces;
    double heat = 0.0;            ///< of all surfaces
    double to_surroundings = 0.0; ///< through openings, and to the backs of faces, which are as warm
};

/// Solves, for differences to the reference temperature (scene/thermal.h),
///     b_i = E_i + rho_i sum_j F_ij b_j,
/// and for the temperatures of the materials whose heat is prescribed, each of which its surfaces share, by a dense
/// factorisation. What row sums lack goes to the surroundings; without any (ThermalSetting) they must be 1 to a
/// thousandth.
///
/// `scene`: after settle_thermal; `material`, `name`: of each surface, the name for messages. Throws InputError for an
/// open enclosure without surroundings, mirrors, temperatures that are not determined, or if more heat is drawn from a
/// surface than arrives; ResourceError for more surfaces than memory has room for.
Enclosure solve_enclosure(const Scene& scene, const FormFactors& F, const std::vector<Index>& material,
                          const std::vector<std::string>& name, const Execution& execution);

} // namespace difusa
