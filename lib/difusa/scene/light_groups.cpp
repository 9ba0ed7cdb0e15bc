#include <difusa/scene/light_groups.h>

#include <difusa/core/text.h>

#include <algorithm>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

namespace difusa {

namespace {

/// The name in a form every file can hold, on one line. Names that differ in nothing but what no file can hold have the
/// same, and their lights are one set.
std::string name_in_files(const std::string& name) {
    std::string text = storable_text(name);
    std::replace_if(
        text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r' || c == '\t'; }, '_');
    return text;
}

/// Numbers sets in the order in which their names are first asked for.
class SetNumbers {
  public:
    explicit SetNumbers(std::vector<std::string>& names) : names_(names) {}

    /// The set of that name; a new one if there is none.
    Index of(const std::string& light) {
        std::string name = name_in_files(light);
        const auto [place, is_new] = numbers_.try_emplace(name, static_cast<Index>(names_.size()));
        if (is_new) {
            names_.push_back(std::move(name));
        }
        return place->second;
    }

  private:
    std::vector<std::string>& names_;
    std::unordered_map<std::string, Index> numbers_;
};

} // namespace

LightSets all_lights(const Scene& scene) {
    return {{""},
            std::vector<Index>(scene.materials.size(), 0),
            std::vector<Index>(scene.suns.size(), 0),
            std::vector<Index>(scene.point_lights.size(), 0),
            0};
}

LightSets light_groups(const Scene& scene) {
    LightSets sets = all_lights(scene);
    sets.names.clear();
    SetNumbers numbers(sets.names);
    const std::vector<char> used = scene.used_materials();
    for (std::size_t m = 0; m < scene.materials.size(); ++m) {
        const Material& material = scene.materials[m];
        if (used[m] != 0 && (material.emission > 0.0).any()) {
            sets.material[m] = numbers.of(material.light_group.empty() ? material.name : material.light_group);
        }
    }
    for (std::size_t i = 0; i < scene.suns.size(); ++i) {
        if ((scene.suns[i].irradiance > 0.0).any()) {
            sets.sun[i] = numbers.of(scene.suns[i].name.empty() ? "sun" : scene.suns[i].name);
        }
    }
    for (std::size_t i = 0; i < scene.point_lights.size(); ++i) {
        const PointLight& light = scene.point_lights[i];
        if ((light.intensity > 0.0).any()) {
            sets.point[i] = numbers.of(!light.name.empty()  ? light.name
                                       : light.distribution ? "luminaire"
                                       : light.is_spot()    ? "spot"
                                                            : "point");
        }
    }
    if (scene.has_sky()) {
        sets.sky = numbers.of("sky");
    }
    if (sets.names.empty()) {
        sets.names.emplace_back();
    }
    return sets;
}

} // namespace difusa
