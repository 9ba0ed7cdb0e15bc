// Thermal radiation of grey, diffuse surfaces. What is known of a surface of emissivity e, with the irradiation h, and
// what follows for its net flux q, the heat that leaves it per area, and for its radiosity b:
//     q = e (sigma T⁴ - h),   b = h + q = e sigma T⁴ + (1 - e) h.
// A fixed temperature makes it emit e sigma T⁴ and reflect 1 - e; a prescribed net flux makes it emit q, which may be
// negative, and reflect everything, whatever its emissivity, and its temperature follows: sigma T⁴ = h + q/e. The
// radiosity equation is the same in both cases. Of a partial mirror, which reflects the share s specularly, 1 - e
// becomes 1 - e - s, and "everything" 1 - s.
//
// The equation is solved for differences to the state in which everything is at a reference temperature, that of the
// surroundings: in it nothing exchanges heat. Differences of a hundredth of a kelvin are then not lost beside 459 W/m²,
// the surroundings emit nothing, and whatever is lost (on the backs of faces, between mirrors) counts as exchanged with
// black surfaces at the reference temperature.
#pragma once

#include <difusa/core/types.h>

#include <optional>
#include <string>

namespace difusa {

inline constexpr double stefan_boltzmann = 5.670374419e-8; ///< W/(m² K⁴) (CODATA 2018, exact but for rounding)
inline constexpr double zero_celsius = 273.15;             ///< K
inline constexpr double hottest = 1e6;                     ///< K: more is taken for a mistake

/// What is known of a surface.
struct Thermal {
    enum class Given {
        temperature, ///< `value` in K
        net_flux,    ///< `value` in W/m² leaves each point, which has a temperature of its own; 0: adiabatic
        heat         ///< `value` in W leaves all faces of the material together, which have one temperature
    };
    Given given = Given::temperature;
    double value = 0.0;
    double emissivity = 1.0;                ///< in [0, 1]; irrelevant where the net flux is 0
    std::optional<double> temperature = {}; ///< K, uniform: the given one, or of `heat` once it has been solved for
};

/// Of a whole scene.
struct ThermalSetting {
    std::optional<double> surroundings; ///< K; absent: the surface is closed
    double reference = 0.0;             ///< K (settle_thermal)
};

struct Material;
struct Scene;

/// sigma (T⁴ - reference⁴), W/m², accurate for small differences.
double excess_power(double temperature, double reference);

/// Temperature in K of what emits this much more than a black surface at the reference temperature does, W/m²; nothing
/// if it would emit less than nothing.
std::optional<double> temperature_of(double excess, double reference);

/// True if a material that occurs is thermal, or if the scene has surroundings.
bool is_thermal(const Scene& scene);

/// Makes the scene a thermal one if some of its materials that occur are, or if it has surroundings: chooses the
/// reference, the temperature of the surroundings, or else that of black surfaces which emit as much as those of fixed
/// temperature do on average (by area), and derives reflectance and emission of the materials from it. Does nothing to
/// other scenes. Throws InputError if only some materials are thermal (those which are nothing but mirrors need not
/// be), if one has a value out of range or reflects or emits otherwise, if there is light besides, or if no temperature
/// is known.
void settle_thermal(Scene& scene);

/// Gives a material whose heat is prescribed this temperature, and its emission.
void set_temperature(Scene& scene, Index material, double temperature);

/// The message where a material whose heat is prescribed has no such temperature.
std::string colder_than_possible(const Material& material);

/// One channel of the state of a point of the surface.
struct ThermalState {
    double temperature = 0.0; ///< K
    double net_flux = 0.0;    ///< W/m², positive if it leaves the surface
    double radiosity = 0.0;   ///< W/m², without what it reflects specularly
    double irradiation = 0.0; ///< W/m², at least 0
    double emissivity = 0.0;  ///< 0 of what is nothing but a mirror; its temperature is that of a surface that, in its
                              ///< place, exchanges no heat
};

/// Of a point of this material, from the irradiation that it has in excess of that at the reference temperature (the
/// irradiance that the scene is solved for). Nothing if more heat is drawn from it than arrives.
std::optional<ThermalState> thermal_state(const Scene& scene, Index material, double excess_irradiation);

} // namespace difusa
