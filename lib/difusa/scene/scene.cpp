#include <difusa/scene/scene.h>

#include <difusa/core/colour.h>
#include <difusa/core/error.h>
#include <difusa/core/text.h>
#include <difusa/mesh/smooth_sides.h>

#include <algorithm>
#include <cmath>

namespace difusa {

namespace {

/// The texture's factor at x; 1 without a texture.
Rgb factor(const Texture* texture, const Mesh& mesh, const SurfacePoint& x) {
    if (texture == nullptr) {
        return Rgb::Ones();
    }
    const std::array<TextureCoordinates, 3>& corner = mesh.corner_texture[x.face];
    return texture->at((1.0 - x.u - x.v) * corner[0] + x.u * corner[1] + x.v * corner[2]);
}

/// Whether the texture differs between two joined sides, somewhere along them.
bool differs(const Texture* texture, const Mesh& mesh, std::size_t side, std::size_t other) {
    constexpr int places = 9;
    constexpr double visible =
        1e-3; // of the brightest pixel: more than rounded coordinates change, and less than a bit
    if (texture == nullptr) {
        return false;
    }
    const auto corner = [&](std::size_t c) -> const TextureCoordinates& { return mesh.corner_texture[c / 3][c % 3]; };
    const TextureCoordinates &begin = corner(side), &end = corner(after(side));
    const TextureCoordinates &other_begin = corner(after(other)), &other_end = corner(other);
    if (begin == other_begin && end == other_end) {
        return false;
    }
    const double least = visible * texture->brightest().maxCoeff();
    for (int i = 0; i < places; ++i) {
        const double t = static_cast<double>(i) / (places - 1);
        const Rgb colour = texture->at((1.0 - t) * begin + t * end);
        if (((colour - texture->at((1.0 - t) * other_begin + t * other_end)).abs() > least).any()) {
            return true;
        }
    }
    return false;
}

bool equal_channels(const Texture* texture) {
    return texture == nullptr || texture->is_grey();
}

} // namespace

Rgb Scene::reflectance(const SurfacePoint& x) const {
    const Material& material = materials[mesh.material[x.face]];
    Rgb rho = material.reflectance;
    if (material.vertex_colours) {
        const std::array<Rgb, 3>& corner = mesh.corner_reflectance[x.face];
        rho = (1.0 - x.u - x.v) * corner[0] + x.u * corner[1] + x.v * corner[2];
    }
    return material.reflectance_texture ? Rgb(rho * factor(material.reflectance_texture.get(), mesh, x)) : rho;
}

Rgb Scene::emission(const SurfacePoint& x) const {
    const Material& material = materials[mesh.material[x.face]];
    if (!material.emits_unevenly()) {
        return material.emission;
    }
    const double pattern = material.emission_pattern ? material.emission_pattern(x.position) : 1.0;
    if (!(pattern >= 0.0 && std::isfinite(pattern))) {
        throw InputError("the emission pattern of the material " + material.name + " is " + text_of(pattern) + " at " +
                         coordinates(x.position) + ": it must be finite and not negative");
    }
    return pattern * material.emission * factor(material.emission_texture.get(), mesh, x);
}

double Scene::pixels_of_emission(Index triangle) const {
    const Texture* const texture = materials[mesh.material[triangle]].emission_texture.get();
    return texture != nullptr ? texture->pixels(mesh.corner_texture[triangle]) : 0.0;
}

std::vector<char> Scene::texture_seams() const {
    std::vector<char> seams;
    for (std::size_t side = 0; side < mesh.twin.size() && !mesh.corner_texture.empty(); ++side) {
        const std::size_t other = mesh.twin[side];
        if (other == none || other < side) {
            continue;
        }
        const Material& material = materials[mesh.material[triangle_of(side)]];
        if (mesh.material[triangle_of(other)] == mesh.material[triangle_of(side)] &&
            (differs(material.reflectance_texture.get(), mesh, side, other) ||
             differs(material.emission_texture.get(), mesh, side, other))) {
            seams.resize(mesh.twin.size(), 0);
            seams[side] = seams[other] = 1;
        }
    }
    return seams;
}

std::vector<char> Scene::used_materials() const {
    std::vector<char> used(materials.size(), 0);
    for (const Index m : mesh.material) {
        used[m] = 1;
    }
    return used;
}

bool Scene::has_uneven_emitters() const {
    return std::any_of(materials.begin(), materials.end(), [](const Material& material) {
        return material.emits_unevenly() && (material.emission > 0.0).any();
    });
}

bool Scene::has_emitters() const {
    return std::any_of(mesh.material.begin(), mesh.material.end(),
                       [this](Index m) { return (materials[m].emission != 0.0).any(); });
}

bool Scene::is_grey() const {
    if (!equal_channels(sky) || (dome && !dome->is_grey()) ||
        !std::all_of(suns.begin(), suns.end(), [](const Sun& sun) { return equal_channels(sun.irradiance); }) ||
        !std::all_of(point_lights.begin(), point_lights.end(),
                     [](const PointLight& light) { return equal_channels(light.intensity); })) {
        return false;
    }
    const std::vector<char> used = used_materials();
    for (std::size_t m = 0; m < materials.size(); ++m) {
        const Material& material = materials[m];
        const bool rho_grey = (material.vertex_colours || equal_channels(material.reflectance)) &&
                              equal_channels(material.reflectance_texture.get());
        if (used[m] != 0 && !(rho_grey && equal_channels(material.specular()) && equal_channels(material.emission) &&
                              equal_channels(material.emission_texture.get()))) {
            return false;
        }
    }
    for (std::size_t t = 0; t < mesh.corner_reflectance.size(); ++t) {
        if (materials[mesh.material[t]].vertex_colours &&
            !std::all_of(mesh.corner_reflectance[t].begin(), mesh.corner_reflectance[t].end(),
                         [](const Rgb& rho) { return equal_channels(rho); })) {
            return false;
        }
    }
    return true;
}

void settle_mirrors(Scene& scene, std::size_t most) {
    Mirrors& mirrors = scene.mesh.mirrors;
    mirrors = {};
    mirrors.most = most;
    std::vector<Index> kind(scene.materials.size(), none);
    for (Index t = 0; t < scene.mesh.triangles.size(); ++t) {
        const Index m = scene.mesh.material[t];
        const Rgb& share = scene.materials[m].mirror;
        if (!(share > 0.0).any()) {
            continue;
        }
        if (kind[m] == none) {
            const auto same = std::find_if(mirrors.reflectance.begin(), mirrors.reflectance.end(),
                                           [&](const Rgb& known) { return (known == share).all(); });
            kind[m] = static_cast<Index>(same - mirrors.reflectance.begin());
            if (same == mirrors.reflectance.end()) {
                mirrors.reflectance.push_back(share);
            }
            mirrors.of_face.resize(scene.mesh.triangles.size(), none);
        }
        mirrors.of_face[t] = kind[m];
    }
}

void settle_gloss(Scene& scene) {
    GlossySurfaces& glossy = scene.mesh.glossy;
    glossy = {};
    std::vector<Index> kind(scene.materials.size(), none);
    for (Index t = 0; t < scene.mesh.triangles.size(); ++t) {
        const Index m = scene.mesh.material[t];
        const std::optional<Gloss>& gloss = scene.materials[m].gloss;
        if (!gloss || !(gloss->reflectance > 0.0).any()) {
            continue;
        }
        if (kind[m] == none) {
            const auto same = std::find_if(glossy.lobes.begin(), glossy.lobes.end(),
                                           [&](const auto& lobe) { return lobe->shape() == gloss->shape; });
            kind[m] = static_cast<Index>(glossy.kinds.size());
            glossy.kinds.push_back({static_cast<Index>(same - glossy.lobes.begin()), gloss->reflectance});
            if (same == glossy.lobes.end()) {
                glossy.lobes.push_back(std::make_shared<GlossyLobe>(gloss->shape));
            }
            glossy.of_face.resize(scene.mesh.triangles.size(), none);
        }
        glossy.of_face[t] = kind[m];
    }
}

std::vector<char> emitting_materials(const Scene& scene) {
    std::vector<char> emits(scene.materials.size(), 0);
    for (std::size_t m = 0; m < emits.size(); ++m) {
        emits[m] = (scene.materials[m].emission != 0.0).any() ? 1 : 0;
    }
    return emits;
}

} // namespace difusa
