#include <difusa/scene/thermal.h>

#include <difusa/core/error.h>
#include <difusa/core/text.h>
#include <difusa/scene/scene.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace difusa {

namespace {

using Given = Thermal::Given;

bool is_pure_mirror(const Material& material) {
    return (material.mirror == 1.0).all() && (material.emission == 0.0).all();
}

std::string own_name(const Material& material) {
    return "the material " + (material.name.empty() ? std::string("without a name") : material.name);
}

/// Throws InputError unless the material, which occurs in a thermal scene, can be one.
void check_thermal_material(const Material& material) {
    const auto refuse = [&](const std::string& why) { throw InputError(own_name(material) + " " + why); };
    if (!material.thermal) {
        if (!is_pure_mirror(material)) {
            refuse("has no thermal properties, but others have: give every surface a \"temperature\" (with an "
                   "\"emissivity\"), a \"net_flux\", a \"heat\", or \"adiabatic\": true");
        }
        return;
    }
    const Thermal& thermal = *material.thermal;
    if (material.vertex_colours || material.reflectance_texture || material.emits_unevenly()) {
        refuse("has colours or textures, which thermal materials cannot have: its emissivity says what it reflects");
    }
    if (!(thermal.emissivity >= 0.0 && thermal.emissivity <= 1.0)) {
        refuse("has the emissivity " + text_of(thermal.emissivity) + ": it must be from 0 to 1");
    }
    if (!(material.mirror == material.mirror[0]).all() || !(thermal.emissivity + material.mirror[0] <= 1.0 + 1e-9)) {
        refuse("reflects as a mirror, in all channels alike, at most what it does not absorb: 1 - emissivity");
    }
    const double largest = thermal.given == Given::temperature ? hottest : 1e30;
    if (!(std::abs(thermal.value) <= largest) || (thermal.given == Given::temperature && thermal.value < 0.0)) {
        refuse(thermal.given == Given::temperature
                   ? "has the temperature " + text_of(thermal.value) + " K: it must be from 0 to 1e6 K"
                   : "has a heat or net flux that is not a number of magnitude up to 1e30: " + text_of(thermal.value));
    }
    const bool needs_to_absorb =
        thermal.given == Given::heat || (thermal.given == Given::net_flux && thermal.value != 0.0);
    if (needs_to_absorb && !(thermal.emissivity > 0.0)) {
        refuse("has the emissivity 0, so that it cannot give away or take in heat: raise it, or make it adiabatic");
    }
}

/// The fourth power that black surfaces which emit as much as those of fixed temperature do on average have; the
/// temperature itself where they all have the same.
std::optional<double> mean_temperature(const Scene& scene, const std::vector<double>& area) {
    double weights = 0.0, sum = 0.0, least = std::numeric_limits<double>::infinity(), most = 0.0;
    for (std::size_t m = 0; m < area.size(); ++m) {
        const std::optional<Thermal>& thermal = scene.materials[m].thermal;
        if (area[m] > 0.0 && thermal && thermal->given == Given::temperature) {
            weights += area[m];
            sum += area[m] * std::pow(thermal->value, 4);
            least = std::min(least, thermal->value);
            most = std::max(most, thermal->value);
        }
    }
    if (!(weights > 0.0)) {
        return std::nullopt;
    }
    return least == most ? least : std::clamp(std::pow(sum / weights, 0.25), least, most);
}

void derive_light(const Scene& scene, Material& material) {
    if (!material.thermal) {
        material.reflectance = Rgb::Zero();
        return;
    }
    Thermal& thermal = *material.thermal;
    const double diffuse = std::max(0.0, 1.0 - material.mirror[0]);
    if (thermal.given == Given::net_flux) {
        material.reflectance = Rgb::Constant(diffuse);
        material.emission = Rgb::Constant(thermal.value);
        return;
    }
    material.reflectance = Rgb::Constant(std::max(0.0, diffuse - thermal.emissivity));
    material.emission = Rgb::Zero();
    if (thermal.given == Given::temperature) {
        thermal.temperature = thermal.value;
    }
    if (thermal.temperature) {
        material.emission =
            Rgb::Constant(thermal.emissivity * excess_power(*thermal.temperature, scene.thermal->reference));
    }
}

} // namespace

double excess_power(double temperature, double reference) {
    return stefan_boltzmann * (temperature - reference) * (temperature + reference) *
           (temperature * temperature + reference * reference);
}

std::optional<double> temperature_of(double excess, double reference) {
    if (excess == 0.0) {
        return reference;
    }
    const double own = std::pow(reference, 4), fourth = excess / stefan_boltzmann + own;
    constexpr double rounding = 0x1p-48; // of the fourth power that is taken away
    return fourth >= -rounding * own ? std::optional(std::pow(std::max(0.0, fourth), 0.25)) : std::nullopt;
}

bool is_thermal(const Scene& scene) {
    return scene.thermal || std::any_of(scene.mesh.material.begin(), scene.mesh.material.end(),
                                        [&](Index m) { return scene.materials[m].thermal.has_value(); });
}

void settle_thermal(Scene& scene) {
    if (!is_thermal(scene)) {
        return;
    }
    std::vector<double> area(scene.materials.size(), 0.0);
    std::vector<char> occurs(scene.materials.size(), 0);
    for (Index t = 0; t < scene.mesh.triangles.size(); ++t) {
        area[scene.mesh.material[t]] += scene.mesh.areas[t];
        occurs[scene.mesh.material[t]] = 1;
    }
    for (std::size_t m = 0; m < occurs.size(); ++m) {
        if (occurs[m] != 0) {
            check_thermal_material(scene.materials[m]);
        }
    }
    if (scene.has_sky() || !scene.suns.empty() || !scene.point_lights.empty()) {
        throw InputError("a thermal scene has no lights and no sky: say how warm its surroundings are, "
                         "\"surroundings\": {\"temperature\": 293.15}, and prescribe what surfaces absorb of the sun "
                         "as part of their net flux");
    }
    ThermalSetting setting = scene.thermal.value_or(ThermalSetting());
    if (setting.surroundings && !(*setting.surroundings >= 0.0 && *setting.surroundings <= hottest)) {
        throw InputError("the surroundings have the temperature " + text_of(*setting.surroundings) +
                         " K: it must be from 0 to 1e6 K");
    }
    const std::optional<double> mean = mean_temperature(scene, area);
    if (!setting.surroundings && !mean) {
        throw InputError("no temperature is known: fix that of some surface, or of the \"surroundings\"; net fluxes "
                         "alone do not determine any");
    }
    setting.reference = setting.surroundings ? *setting.surroundings : *mean;
    scene.thermal = setting;
    for (std::size_t m = 0; m < occurs.size(); ++m) {
        if (occurs[m] != 0) {
            derive_light(scene, scene.materials[m]);
        }
    }
}

void set_temperature(Scene& scene, Index material, double temperature) {
    scene.materials[material].thermal->temperature = temperature;
    derive_light(scene, scene.materials[material]);
}

std::string colder_than_possible(const Material& material) {
    return "more heat is drawn than arrives: " + own_name(material) +
           " would have to be colder than 0 K for its heat of " + text_of(material.thermal->value) +
           " W; draw less there, or from what it sees";
}

std::optional<ThermalState> thermal_state(const Scene& scene, Index number, double excess_irradiation) {
    const Material& material = scene.materials[number];
    const double reference = scene.thermal->reference, power = excess_power(reference, 0.0);
    // A basis with negative weights may undershoot.
    const double h = std::max(excess_irradiation, -power);
    ThermalState state;
    state.irradiation = h + power;
    const double diffuse = std::max(0.0, 1.0 - material.mirror[0]);
    if (material.thermal && material.thermal->given != Given::net_flux) {
        const Thermal& thermal = *material.thermal;
        DIFUSA_REQUIRE(thermal.temperature.has_value());
        const double own = excess_power(*thermal.temperature, reference);
        state.temperature = *thermal.temperature;
        state.emissivity = thermal.emissivity;
        state.net_flux = thermal.emissivity * (own - h);
        state.radiosity = thermal.emissivity * own + material.reflectance[0] * h + diffuse * power;
        return state;
    }
    double own = h;
    if (material.thermal) {
        state.emissivity = material.thermal->emissivity;
        state.net_flux = material.thermal->value;
        own += state.net_flux != 0.0 ? state.net_flux / state.emissivity : 0.0;
    }
    const std::optional<double> temperature = temperature_of(own, reference);
    if (!temperature) {
        return std::nullopt;
    }
    state.temperature = *temperature;
    state.radiosity = state.net_flux + diffuse * h + diffuse * power;
    return state;
}

} // namespace difusa
