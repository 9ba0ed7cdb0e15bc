// Scenes with sites, ready for transport.
#pragma once

#include <difusa/discretisation/sampler.h>
#include <difusa/discretisation/site_set.h>
#include <difusa/scene/scene.h>

#include <support/plugins.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace difusa::test {

/// All of the mesh made of one material.
inline Scene uniform_scene(Mesh mesh, double rho, double E) {
    Scene scene;
    scene.mesh = std::move(mesh);
    Material material;
    material.reflectance = Rgb::Constant(rho);
    material.emission = Rgb::Constant(E);
    scene.materials.push_back(material);
    return scene;
}

inline SiteSet poisson_sites(const Mesh& mesh, double spacing, std::uint64_t seed = 1, int neighbours = 10) {
    const Execution execution;
    return make_site_set(mesh,
                         plugin<Sampler>("poisson-disk")
                             ->sample(mesh, nullptr, spacing, 1'000'000, RandomStream(seed, "sites"), execution),
                         spacing, neighbours, execution);
}

/// The median of the sites' radii (the upper one of an even number).
inline double median_radius(const SiteSet& sites) {
    std::vector<double> radius = sites.radius;
    std::sort(radius.begin(), radius.end());
    return radius[radius.size() / 2];
}

} // namespace difusa::test
