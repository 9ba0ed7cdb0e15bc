#include <difusa/output/enclosure_files.h>

#include <difusa/core/digits.h>
#include <difusa/core/error.h>
#include <difusa/core/text.h>
#include <difusa/import/text_scanner.h>
#include <difusa/output/text_table.h>
#include <difusa/output/thermal_files.h>

#include <algorithm>
#include <cmath>

namespace difusa {

void check_enclosure_file(const std::filesystem::path& file) {
    if (lower_case(file.extension().string()) != ".csv") {
        throw UsageError("cannot write temperatures and fluxes to `" + file.string() +
                         "`: the name must end in .csv (a table)");
    }
}

std::string enclosure_table(const Scene& scene, const Enclosure& enclosure, const std::vector<std::string>& name) {
    std::string text = "surface,material,given,area,emissivity,temperature,net_flux,heat,radiosity,irradiance,"
                       "net_flux_error,temperature_error\n";
    for (std::size_t i = 0; i < enclosure.surfaces.size(); ++i) {
        const EnclosureSurface& surface = enclosure.surfaces[i];
        const ThermalState& state = surface.state;
        const Material& material = scene.materials[surface.material];
        text += csv_quoted(name[i]) + "," + csv_quoted(material.name) + "," + given_word(material);
        for (const double value :
             {surface.area, state.emissivity, state.temperature, state.net_flux, surface.area * state.net_flux,
              state.radiosity, state.irradiation, surface.net_flux_error, surface.temperature_error}) {
            text += "," + exact_text(value);
        }
        text += "\n";
    }
    const double reference = scene.thermal->reference;
    return text + csv_quoted("(surroundings)") + ",,temperature,,1," + exact_text(reference) + ",," +
           exact_text(-enclosure.to_surroundings) + "," + exact_text(excess_power(reference, 0.0)) + ",,,\n";
}

std::string enclosure_summary(const Scene& scene, const Enclosure& enclosure, const std::vector<std::string>& name,
                              std::size_t most) {
    std::vector<std::vector<std::string>> rows{
        {"surface", "area", "emissivity", "given", "temperature, K", "net flux, W/m^2", "heat, W", "radiosity, W/m^2"}};
    double flux_error = 0.0, temperature_error = 0.0;
    for (std::size_t i = 0; i < enclosure.surfaces.size(); ++i) {
        const EnclosureSurface& surface = enclosure.surfaces[i];
        const Material& material = scene.materials[surface.material];
        flux_error = std::max(flux_error, surface.net_flux_error);
        temperature_error = std::max(temperature_error, surface.temperature_error);
        rows.push_back({name[i], formatted("%.5g", surface.area), formatted("%.3g", surface.state.emissivity),
                        given_word(material), formatted("%.4f", surface.state.temperature),
                        formatted("%.6g", surface.state.net_flux),
                        formatted("%.6g", surface.area * surface.state.net_flux),
                        formatted("%.6g", surface.state.radiosity)});
    }
    std::string text = rows.size() <= most + 1 ? text_table(rows) : "";
    text += "heat (W, positive if it leaves the surfaces): all surfaces " + formatted("%.6g", enclosure.heat) +
            (scene.thermal->surroundings ? ", to the surroundings at " : ", lost by errors of row sums, as if to ") +
            formatted("%.4f", scene.thermal->reference) + " K " + formatted("%.6g", enclosure.to_surroundings) + "\n";
    text += "errors of the form factors change net fluxes by at most " + with_digits(flux_error, 2) +
            " W/m^2, temperatures by at most " + with_digits(temperature_error, 2) + " K\n";
    return text;
}

} // namespace difusa
