#include <difusa/scene/scene.h>

#include <algorithm>

namespace difusa {

Rgb Scene::reflectance(const SurfacePoint& x) const {
    const Material& material = materials[mesh.material[x.face]];
    if (!material.vertex_colours) {
        return material.reflectance;
    }
    const std::array<Rgb, 3>& rho = mesh.corner_reflectance[x.face];
    return (1.0 - x.u - x.v) * rho[0] + x.u * rho[1] + x.v * rho[2];
}

bool Scene::has_emitters() const {
    return std::any_of(mesh.material.begin(), mesh.material.end(),
                       [this](Index m) { return (materials[m].emission > 0.0).any(); });
}

bool Scene::is_grey() const {
    const auto grey = [](const Rgb& c) { return c[0] == c[1] && c[1] == c[2]; };
    if (!grey(sky) || !std::all_of(suns.begin(), suns.end(), [&](const Sun& sun) { return grey(sun.irradiance); })) {
        return false;
    }
    std::vector<char> used(materials.size(), 0);
    for (const Index m : mesh.material) {
        used[m] = 1;
    }
    for (std::size_t m = 0; m < materials.size(); ++m) {
        const bool rho_grey = materials[m].vertex_colours || grey(materials[m].reflectance);
        if (used[m] != 0 && !(rho_grey && grey(materials[m].emission))) {
            return false;
        }
    }
    for (std::size_t t = 0; t < mesh.corner_reflectance.size(); ++t) {
        if (materials[mesh.material[t]].vertex_colours &&
            !std::all_of(mesh.corner_reflectance[t].begin(), mesh.corner_reflectance[t].end(), grey)) {
            return false;
        }
    }
    return true;
}

} // namespace difusa
