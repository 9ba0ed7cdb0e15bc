// What pictures show, and how values become colours.
#pragma once

#include <difusa/scene/scene.h>

#include <optional>
#include <span>
#include <string>

namespace difusa {

/// What a picture can show.
enum class Quantity {
    radiosity,           ///< E + rho H
    direct,              ///< E + rho H_direct: as if only the visible surface reflected light
    indirect,            ///< rho H_indirect, the rest
    group,               ///< the radiosity of one light group
    irradiance,          ///< H
    irradiance_direct,   ///< H_direct
    irradiance_indirect, ///< H_indirect
    emission,            ///< E
    reflectance,         ///< rho
    luminance,           ///< of the radiosity, cd/m² (core/photometry.h)
    illuminance,         ///< of the irradiance, lux
    radiosity_weighted,  ///< mean of the radiosity's channels, weighted by their luminance, W/m²
    irradiance_weighted, ///< likewise
    temperature,         ///< of a thermal scene, K
    net_flux,            ///< likewise, W/m²
    error,               ///< BakeResult::errors
    illuminance_error,   ///< likewise, of the irradiance
    basis,               ///< one basis element, or the sum of all
    sites                ///< dots on pale surfaces
};

/// How values become colours.
enum class Colouring { light, plain, map, dots };
Colouring colouring_of(Quantity quantity);

/// The content of one picture.
struct Show {
    Quantity quantity = Quantity::radiosity;
    std::string group;            ///< name of the light group
    std::optional<Index> element; ///< of the basis; absent: the sum
    std::string title;            ///< above the colour bar, "luminance, cd/m^2"
};

/// A name as typed by a user: "radiosity", "irradiance-direct", "group:NAME". Throws UsageError with the nearest name
/// and all names.
Show parse_show(const std::string& text);

/// True for the light that leaves surfaces, which mirrors show.
bool shows_in_mirrors(Quantity quantity);

/// True for those that are also defined of the sky, and of the surroundings of a thermal scene.
bool shows_sky(Quantity quantity);

/// Throws UsageError for light of a thermal scene, and for temperatures of another. The weighted radiosity and
/// irradiance are those of the radiation.
void check_shows(const Scene& scene, std::span<const Show> shows);

} // namespace difusa
