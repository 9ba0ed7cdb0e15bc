// Light straight from emitting faces that are small: lamps. A few hundred rays in all directions meet a small lamp so
// seldom that its light comes out blotchy; its form factor is known exactly, and shadow rays tell which share of it is
// seen. Surfaces that emit over a large part of the scene are left to the rays of the gather, which then are exact in
// the mean and, in a closed scene of constant emission, exact.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/scene/scene.h>
#include <difusa/sites/site_set.h>
#include <difusa/transport/transport.h>
#include <difusa/visibility/visibility.h>

#include <cstdint>
#include <vector>

namespace difusa {

/// The emitting triangles that are lamps: all of them, if they make at most a tenth of the surface, number at most 4096
/// and have at most 32 materials; else none.
std::vector<Index> lamp_triangles(const Scene& scene);

/// Sets transport.L to the light of lamps at the sites:
///     L_jm = sum_{t of material m} F_jt · (visible share),
/// F_jt in closed form (lighting/lambert.h). The visible share of a material's lamps at a site comes from `samples`
/// shadow rays (more where it has several materials), stratified over the lamps by their form factors, weighted by the
/// integrand: exact where nothing blocks. Adds the segments cast to transport.segments.
void gather_lamps(const Scene& scene, const std::vector<Index>& lamps, const SiteSet& sites,
                  const Visibility& visibility, std::size_t samples, std::uint64_t seed, const Execution& execution,
                  Transport& transport);

} // namespace difusa
