#include <difusa/scene/light_groups.h>

#include <difusa/core/text.h>

#include <algorithm>

namespace difusa {

namespace {

/// The name as every file can hold it, on one line: names that differ stay different in the files.
std::string name_in_files(const std::string& name) {
    std::string text = storable_text(name);
    std::replace_if(
        text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r' || c == '\t'; }, '_');
    return text;
}

/// The group of that name; a new one if there is none.
LightGroup& group_of(std::vector<LightGroup>& groups, const std::string& light, const Scene& scene) {
    const std::string name = name_in_files(light);
    const auto found =
        std::find_if(groups.begin(), groups.end(), [&](const LightGroup& group) { return group.name == name; });
    if (found != groups.end()) {
        return *found;
    }
    return groups.emplace_back(LightGroup{name, std::vector<char>(scene.materials.size(), 0),
                                          std::vector<char>(scene.suns.size(), 0),
                                          std::vector<char>(scene.point_lights.size(), 0), false});
}

} // namespace

LightGroup all_lights(const Scene& scene) {
    return {"", std::vector<char>(scene.materials.size(), 1), std::vector<char>(scene.suns.size(), 1),
            std::vector<char>(scene.point_lights.size(), 1), true};
}

std::vector<LightGroup> light_groups(const Scene& scene) {
    std::vector<LightGroup> groups;
    std::vector<char> used(scene.materials.size(), 0);
    for (const Index material : scene.mesh.material) {
        used[material] = 1;
    }
    for (std::size_t m = 0; m < scene.materials.size(); ++m) {
        const Material& material = scene.materials[m];
        if (used[m] != 0 && (material.emission > 0.0).any()) {
            group_of(groups, material.light_group.empty() ? material.name : material.light_group, scene).materials[m] =
                1;
        }
    }
    for (std::size_t i = 0; i < scene.suns.size(); ++i) {
        if ((scene.suns[i].irradiance > 0.0).any()) {
            group_of(groups, scene.suns[i].name.empty() ? "sun" : scene.suns[i].name, scene).suns[i] = 1;
        }
    }
    for (std::size_t i = 0; i < scene.point_lights.size(); ++i) {
        const PointLight& light = scene.point_lights[i];
        if ((light.intensity > 0.0).any()) {
            const std::string kind = light.is_spot() ? "spot" : "point";
            group_of(groups, light.name.empty() ? kind : light.name, scene).points[i] = 1;
        }
    }
    if (scene.has_sky()) {
        group_of(groups, "sky", scene).sky = true;
    }
    return groups;
}

} // namespace difusa
