#include <difusa/render/show.h>

#include <difusa/core/error.h>
#include <difusa/plugin/parameters.h>
#include <difusa/scene/light_groups.h>

#include <algorithm>
#include <vector>

namespace difusa {

namespace {

struct ShowName {
    const char* text;
    Quantity quantity;
    const char* title;
};

constexpr ShowName show_names[] = {
    {"radiosity", Quantity::radiosity, ""},
    {"direct", Quantity::direct, ""},
    {"indirect", Quantity::indirect, ""},
    {"irradiance", Quantity::irradiance, ""},
    {"irradiance-direct", Quantity::irradiance_direct, ""},
    {"irradiance-indirect", Quantity::irradiance_indirect, ""},
    {"emission", Quantity::emission, ""},
    {"reflectance", Quantity::reflectance, ""},
    {"luminance", Quantity::luminance, "luminance, cd/m^2"},
    {"illuminance", Quantity::illuminance, "illuminance, lux"},
    {"radiosity-weighted", Quantity::radiosity_weighted, "radiosity, W/m^2"},
    {"irradiance-weighted", Quantity::irradiance_weighted, "irradiance, W/m^2"},
    {"temperature", Quantity::temperature, "temperature, K"},
    {"net-flux", Quantity::net_flux, "net flux, W/m^2"},
    {"error", Quantity::error, "estimated error, W/m^2"},
    {"illuminance-error", Quantity::illuminance_error, "estimated error of the illuminance, lux"},
    {"basis", Quantity::basis, "sum of basis"},
    {"sites", Quantity::sites, ""},
};

std::string show_name_of(Quantity quantity) {
    const auto* const found = std::find_if(std::begin(show_names), std::end(show_names),
                                           [&](const ShowName& name) { return name.quantity == quantity; });
    return found == std::end(show_names) ? "group" : found->text;
}

} // namespace

bool shows_in_mirrors(Quantity quantity) {
    switch (quantity) {
    case Quantity::radiosity:
    case Quantity::direct:
    case Quantity::indirect:
    case Quantity::group:
    case Quantity::luminance:
    case Quantity::radiosity_weighted:
        return true;
    default:
        return false;
    }
}

bool shows_sky(Quantity quantity) {
    return shows_in_mirrors(quantity) && quantity != Quantity::indirect;
}

Colouring colouring_of(Quantity quantity) {
    switch (quantity) {
    case Quantity::luminance:
    case Quantity::illuminance:
    case Quantity::radiosity_weighted:
    case Quantity::irradiance_weighted:
    case Quantity::temperature:
    case Quantity::net_flux:
    case Quantity::error:
    case Quantity::illuminance_error:
    case Quantity::basis:
        return Colouring::map;
    case Quantity::reflectance:
        return Colouring::plain;
    case Quantity::sites:
        return Colouring::dots;
    default:
        return Colouring::light;
    }
}

Show parse_show(const std::string& text) {
    const std::string prefix = "group:";
    if (text.rfind(prefix, 0) == 0 && text.size() > prefix.size()) {
        return {Quantity::group, text.substr(prefix.size()), {}, ""};
    }
    std::string wanted = text, all;
    std::replace(wanted.begin(), wanted.end(), '_', '-');
    std::vector<std::string> known;
    for (const ShowName& name : show_names) {
        if (wanted == name.text) {
            return {name.quantity, "", {}, name.title};
        }
        known.emplace_back(name.text);
        all += std::string(name.text) + ", ";
    }
    const std::string near = nearest_name(text, known);
    throw UsageError("--show " + text + ": unknown" + (near.empty() ? "." : ", did you mean " + near + "?") +
                     " There are " + all + "group:NAME");
}

void check_shows(const Scene& scene, std::span<const Show> shows) {
    const std::vector<std::string> groups = light_groups(scene).names;
    for (const Show& show : shows) {
        const bool thermal = show.quantity == Quantity::temperature || show.quantity == Quantity::net_flux;
        const bool neutral = show.quantity == Quantity::radiosity_weighted ||
                             show.quantity == Quantity::irradiance_weighted || show.quantity == Quantity::error ||
                             show.quantity == Quantity::basis || show.quantity == Quantity::sites;
        if (scene.thermal ? !(thermal || neutral) : thermal) {
            throw UsageError("--show " + show_name_of(show.quantity) + ": " +
                             (thermal ? "the scene is not a thermal one: give its materials temperatures"
                                      : "a thermal scene has no light to show; there are temperature, net-flux, "
                                        "radiosity-weighted, irradiance-weighted, error, basis, sites"));
        }
        if (show.quantity == Quantity::group && std::find(groups.begin(), groups.end(), show.group) == groups.end()) {
            std::string all;
            for (const std::string& group : groups) {
                all += (all.empty() ? "" : ", ") + group;
            }
            throw UsageError("--show group:" + show.group + ": there is no such light group; there are " + all);
        }
    }
}

} // namespace difusa
