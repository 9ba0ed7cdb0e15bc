// Surfaces on which no site would ever do anything: the outside of a closed room, the inside of a wall.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/lighting/direct_light.h>

#include <cstdint>
#include <vector>

namespace difusa {

/// For each region of the mesh 1 if it sees nothing that could send it light: from many places of it, at least one on
/// each triangle, rays meet nothing but backs or leave to a sky without light, and shadow rays towards suns, point
/// lights, lamps and other emitting faces do not get through.
/// What sees nothing is seen by nothing, so such a region plays no part. The rays are finite in number: a region lit
/// only through a hole that all of them miss counts as dark.
std::vector<char> dark_regions(const Scene& scene, const DirectLight& lights, const Tracer& tracer, std::uint64_t seed,
                               const Execution& execution);

} // namespace difusa
