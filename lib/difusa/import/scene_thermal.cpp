#include <difusa/import/scene_thermal.h>

#include <difusa/core/text.h>

#include <algorithm>
#include <cmath>

namespace difusa {

namespace {

/// In K.
double kelvins(const SceneChecks& checks, const JsonValue& value, const std::string& name) {
    const double given = checks.number(value, difusa::quoted(name));
    const double temperature = name == "celsius" ? given + zero_celsius : given;
    if (!(temperature >= 0.0 && temperature <= hottest)) {
        checks.fail(value, difusa::quoted(name) + " is " + text_of(given) +
                               (name == "celsius" ? ": it must be from -273.15 to 999726.85 degrees"
                                                  : ": it must be from 0 to 1e6 K"));
    }
    return temperature;
}

double limited_number(const SceneChecks& checks, const JsonValue& value, const std::string& name) {
    const double given = checks.number(value, difusa::quoted(name));
    if (!(std::abs(given) <= 1e30)) {
        checks.fail(value, difusa::quoted(name) + " must be from -1e30 to 1e30");
    }
    return given;
}

/// Sets what is given: the one member of these.
void read_given(const SceneChecks& checks, const JsonValue& material, Thermal& thermal) {
    const JsonValue* found = nullptr;
    for (const char* name : {"temperature", "celsius", "net_flux", "heat", "adiabatic"}) {
        const JsonValue* value = material.find(name);
        if (value == nullptr) {
            continue;
        }
        if (found != nullptr) {
            checks.fail(*value, "a thermal material has only one of \"temperature\" (K), \"celsius\", \"net_flux\" "
                                "(W/m^2), \"heat\" (W) and \"adiabatic\": the others follow from it");
        }
        found = value;
        const std::string given = name;
        if (given == "temperature" || given == "celsius") {
            thermal.given = Thermal::Given::temperature;
            thermal.value = kelvins(checks, *value, given);
        } else if (given == "adiabatic") {
            thermal.given = Thermal::Given::net_flux;
            if (!checks.truth(*value, difusa::quoted(given))) {
                checks.fail(*value, "\"adiabatic\" is true or left out: false does not say what the surface is");
            }
        } else {
            thermal.given = given == "heat" ? Thermal::Given::heat : Thermal::Given::net_flux;
            thermal.value = limited_number(checks, *value, given);
        }
    }
    if (found == nullptr) {
        checks.fail(material, "a thermal material needs one of \"temperature\" (K), \"celsius\", \"net_flux\" (W/m^2, "
                              "positive if it leaves the surface), \"heat\" (W) and \"adiabatic\": true");
    }
}

} // namespace

const std::vector<std::string>& thermal_members() {
    static const std::vector<std::string> members{"emissivity", "temperature", "celsius",
                                                  "net_flux",   "heat",        "adiabatic"};
    return members;
}

std::optional<Thermal> scene_thermal(const SceneChecks& checks, const JsonValue& material, const Rgb& mirror) {
    if (std::none_of(thermal_members().begin(), thermal_members().end(),
                     [&](const std::string& name) { return material.find(name) != nullptr; })) {
        return std::nullopt;
    }
    for (const char* name :
         {"reflectance", "reflectance_texture", "emission", "luminance", "emission_texture", "light_group"}) {
        if (const JsonValue* other = material.find(name)) {
            checks.fail(*other, difusa::quoted(name) +
                                    ": a thermal material reflects what it does not absorb, and emits what "
                                    "its temperature says: omit it");
        }
    }
    Thermal thermal;
    read_given(checks, material, thermal);
    const JsonValue* emissivity = material.find("emissivity");
    const bool matters = thermal.given != Thermal::Given::net_flux || thermal.value != 0.0;
    if (emissivity == nullptr && matters) {
        checks.fail(material, "a thermal material needs an \"emissivity\", from 0 to 1, unless it is adiabatic");
    }
    const double rest = std::max(0.0, 1.0 - mirror.maxCoeff());
    thermal.emissivity = rest;
    if (emissivity != nullptr) {
        thermal.emissivity = checks.number(*emissivity, quoted("emissivity"));
        if (!(thermal.emissivity >= 0.0 && thermal.emissivity <= 1.0)) {
            checks.fail(*emissivity, "\"emissivity\" must be from 0 (reflects everything) to 1 (black)");
        }
        if (!(thermal.emissivity <= rest + 1e-9)) {
            checks.fail(*emissivity, "\"emissivity\" and \"mirror\" add up to more than 1: a surface absorbs at most "
                                     "what it does not reflect");
        }
        if (matters && thermal.given != Thermal::Given::temperature && thermal.emissivity == 0.0) {
            checks.fail(*emissivity, "\"emissivity\" is 0: such a surface can neither give away nor take in heat");
        }
    }
    return thermal;
}

double scene_surroundings(const SceneChecks& checks, const JsonValue& surroundings) {
    const std::string what = quoted("surroundings");
    checks.members(surroundings, what, {"temperature", "celsius"});
    const JsonValue *kelvin = surroundings.find("temperature"), *celsius = surroundings.find("celsius");
    if ((kelvin == nullptr) == (celsius == nullptr)) {
        checks.refuse_choice(surroundings, what, quoted("temperature"), quoted("celsius"), kelvin != nullptr);
    }
    return kelvin != nullptr ? kelvins(checks, *kelvin, "temperature") : kelvins(checks, *celsius, "celsius");
}

} // namespace difusa
