// What the benchmarks measure in: a scene with sites and a bound basis, made the way a bake makes them.
#pragma once

#include <difusa/core/random.h>
#include <difusa/discretisation/basis.h>
#include <difusa/discretisation/sampler.h>
#include <difusa/discretisation/site_set.h>
#include <difusa/import/reader.h>
#include <difusa/plugin/registry.h>
#include <difusa/repair/diagnosis.h>
#include <difusa/scene/scene.h>

#include <generator/scenes.h>

#include <memory>
#include <string>

namespace difusa::bench {

inline constexpr std::uint64_t seed = 1;
inline constexpr int neighbours = 10;

/// A generated surface as if it had been read from a file.
inline PolygonSoup to_soup(const scenes::Surface& surface) {
    PolygonSoup soup;
    soup.file = "generated";
    for (const scenes::Vector& p : surface.points()) {
        soup.points.emplace_back(p.x, p.y, p.z);
    }
    for (const scenes::Material& m : surface.materials) {
        soup.materials.push_back({m.name,
                                  {m.reflectance.r, m.reflectance.g, m.reflectance.b},
                                  {m.emission.r, m.emission.g, m.emission.b},
                                  false});
    }
    for (const scenes::Face& face : surface.faces()) {
        soup.add_face(face.corners, face.material, 0);
    }
    return soup;
}

/// `file`, or the room with balls of about `triangles` triangles if it is empty.
inline Scene make_scene(const Registry& registry, const std::string& file, std::size_t triangles) {
    const PolygonSoup soup = file.empty() ? to_soup(scenes::room_with_balls(triangles)) : read_soup(registry, file);
    Scene scene;
    scene.mesh = diagnose(soup).mesh;
    scene.materials = soup.materials;
    scene.materials.emplace_back(); // of faces without one
    if (!scene.has_emitters()) {
        scene.sky = Rgb::Ones();
    }
    return scene;
}

/// About `count` Poisson-disk sites.
inline SiteSet make_sites(const Registry& registry, const Scene& scene, std::size_t count, const Execution& execution) {
    const auto sampler = registry.create<Sampler>("poisson-disk");
    const double spacing = spacing_for_count(*sampler, scene.mesh, nullptr, count, seed, execution);
    return make_site_set(
        scene.mesh, sampler->sample(scene.mesh, nullptr, spacing, 100 * count, RandomStream(seed, "sites"), execution),
        spacing, neighbours, execution);
}

inline std::shared_ptr<Basis> make_basis(const Registry& registry, const std::string& choice, const Scene& scene,
                                         const SiteSet& sites) {
    auto basis = registry.create<Basis>(choice);
    basis->bind(scene.mesh, sites);
    return basis;
}

} // namespace difusa::bench
