// Surfaces on which a site would be wasted: the outside of a closed room, the inside of a wall.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/lighting/direct_light.h>

#include <cstdint>
#include <vector>

namespace difusa {

/// For each region of the mesh, 1 if it sees nothing that could send it light: from many points on it, at least one per
/// triangle, rays hit only backs or escape to a dark sky, and shadow rays towards suns, point lights, area lights and
/// other emitting faces are blocked.
/// A region that sees nothing is seen by nothing, so it plays no part in the transport. The number of rays is finite: a
/// region lit only through a hole that all of them miss counts as dark.
std::vector<char> dark_regions(const Scene& scene, const DirectLight& lights, const Tracer& tracer, std::uint64_t seed,
                               const Execution& execution);

} // namespace difusa
