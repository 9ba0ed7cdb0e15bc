#include <difusa/scene/light_groups.h>

#include <difusa/core/text.h>

#include <algorithm>

namespace difusa {

namespace {

/// The name in a form every file can hold, on one line: different names stay different in the files.
std::string name_in_files(const std::string& name) {
    std::string text = storable_text(name);
    std::replace_if(
        text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r' || c == '\t'; }, '_');
    return text;
}

/// The set of that name; a new one if there is none.
Index set_of(LightSets& sets, const std::string& light) {
    const std::string name = name_in_files(light);
    const auto found = std::find(sets.names.begin(), sets.names.end(), name);
    if (found != sets.names.end()) {
        return static_cast<Index>(found - sets.names.begin());
    }
    sets.names.push_back(name);
    return static_cast<Index>(sets.names.size() - 1);
}

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
    std::vector<char> used(scene.materials.size(), 0);
    for (const Index material : scene.mesh.material) {
        used[material] = 1;
    }
    for (std::size_t m = 0; m < scene.materials.size(); ++m) {
        const Material& material = scene.materials[m];
        if (used[m] != 0 && (material.emission > 0.0).any()) {
            sets.material[m] = set_of(sets, material.light_group.empty() ? material.name : material.light_group);
        }
    }
    for (std::size_t i = 0; i < scene.suns.size(); ++i) {
        if ((scene.suns[i].irradiance > 0.0).any()) {
            sets.sun[i] = set_of(sets, scene.suns[i].name.empty() ? "sun" : scene.suns[i].name);
        }
    }
    for (std::size_t i = 0; i < scene.point_lights.size(); ++i) {
        const PointLight& light = scene.point_lights[i];
        if ((light.intensity > 0.0).any()) {
            sets.point[i] = set_of(sets, !light.name.empty()  ? light.name
                                         : light.distribution ? "luminaire"
                                         : light.is_spot()    ? "spot"
                                                              : "point");
        }
    }
    if (scene.has_sky()) {
        sets.sky = set_of(sets, "sky");
    }
    if (sets.names.empty()) {
        sets.names.emplace_back();
    }
    return sets;
}

} // namespace difusa
