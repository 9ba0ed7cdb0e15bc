#include <difusa/output/thermal_files.h>

#include <difusa/core/digits.h>
#include <difusa/output/text_table.h>

#include <cmath>
#include <functional>
#include <sstream>

namespace difusa {

std::vector<FieldArray> thermal_arrays(const ThermalValues& values) {
    const char* const flux = "W/m^2";
    return {{"temperature", "K", {}, std::cref(values.temperature)},
            {"net_flux", flux, {}, std::cref(values.net_flux)},
            {"radiosity", flux, {}, std::cref(values.radiosity)},
            {"irradiance", flux, {}, std::cref(values.irradiation)},
            {"emissivity", "", {}, std::cref(values.emissivity)}};
}

std::vector<FieldNote> thermal_notes(const BakeResult& result) {
    const ThermalSetting& setting = *result.scene->thermal;
    std::vector<FieldNote> notes{{"reference_temperature", std::vector<double>{setting.reference}}};
    if (setting.surroundings) {
        notes.push_back({"surroundings_temperature", std::vector<double>{*setting.surroundings}});
    }
    return notes;
}

std::string given_word(const Material& material) {
    if (!material.thermal) {
        return "mirror";
    }
    switch (material.thermal->given) {
    case Thermal::Given::temperature:
        return "temperature";
    case Thermal::Given::net_flux:
        return material.thermal->value == 0.0 ? "adiabatic" : "net_flux";
    case Thermal::Given::heat:
        return "heat";
    }
    return "";
}

std::string thermal_summary(const BakeResult& result) {
    const ThermalResult& thermal = *result.thermal;
    const bool errors = result.errors.has_value();
    std::vector<std::vector<std::string>> rows{{"material", "area, m^2", "emissivity", "given", "temperature, K",
                                                "least", "largest", "net flux, W/m^2", "net heat, W",
                                                "radiosity, W/m^2"}};
    if (errors) {
        rows.front().emplace_back("error of irradiance, W/m^2");
    }
    for (const ThermalSurface& surface : thermal.surfaces) {
        const Material& material = result.scene->materials[surface.material];
        // A perfect mirror exchanges no heat, and its temperature means nothing; nor does the emissivity where no heat
        // is exchanged.
        const auto kelvin = [&](double value) { return material.thermal ? formatted("%.3f", value) : "-"; };
        const std::string given = given_word(material);
        rows.push_back(
            {material.name, formatted("%.5g", surface.area),
             material.thermal && given != "adiabatic" ? formatted("%.3g", material.thermal->emissivity) : "-", given,
             kelvin(surface.mean_temperature), kelvin(surface.least_temperature), kelvin(surface.largest_temperature),
             formatted("%.5g", surface.area > 0.0 ? surface.heat / surface.area : 0.0), formatted("%.5g", surface.heat),
             formatted("%.5g", surface.radiosity)});
        if (errors) {
            rows.back().push_back(with_digits(surface.error, 2));
        }
    }
    std::ostringstream text;
    text << text_table(rows) << "heat (W, positive if it leaves the surfaces): all surfaces "
         << formatted("%.5g", thermal.heat) << ", to the surroundings " << formatted("%.5g", thermal.to_surroundings)
         << ", to backs and lost between mirrors " << formatted("%.5g", thermal.to_backs) << "; imbalance "
         << with_digits(thermal.imbalance(), 2);
    if (thermal.exchanged > 0.0) {
        text << ", " << with_digits(100.0 * std::abs(thermal.imbalance()) / thermal.exchanged, 2)
             << " % of what is exchanged";
    }
    text << "\n";
    return text.str();
}

} // namespace difusa
