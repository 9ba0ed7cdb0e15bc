// The transport of a surface of which some faces have moved, from that of the surface as it was: only rays that may
// meet what has moved, where it was or where it is, are cast again.
#pragma once

#include <difusa/transport/gathered.h>

#include <span>

namespace difusa {

/// A surface, where light is gathered on it, and its surfels.
struct GatherScene {
    Tracer tracer;
    std::span<const SurfacePoint> points;
    const Surfels& surfels;
};

/// The work that was done and saved.
struct RecastCount {
    std::size_t anew = 0; ///< rays of the points that were cast again, once or, before and after, twice
    std::size_t kept = 0; ///< rays that were not
    std::size_t cast =
        0; ///< first-hit rays cast, those before and after counted each, not counting those after mirrors
};

/// What `gathered` gives for the surface `after` with these directions, rays and seed, identical to the bit.
///
/// `transport`: what it gave for the surface `before`. Both meshes have the same triangles and mirrors, the same points
/// on the same places of these, and surfels by the same edge; triangles that are not marked (#T) are in the same place.
///
/// A ray that starts on a marked triangle is cast anew. Of the others those are that pass through a box around marked
/// triangles, before or after, or around surfels that these cut otherwise than before: in its list of hits, the row
/// of such a ray's point loses the surfel that the ray ended on before, and gains the one it ends on after. What is
/// seen in mirrors is built from all rays that pass through a box around a mirror. Where directions have different
/// weights, a row with such rays is gathered anew. All rays are cast anew if the largest coordinate has changed, which
/// rounding is relative to, and where the surface goes on beyond its mesh.
///
/// Throws InputError if the lists do not belong to the surface `before`.
LightTransport recast(const LightTransport& transport, const GatherScene& before, const GatherScene& after,
                      std::span<const char> marked, const Directions& directions, std::size_t rays, std::uint64_t seed,
                      RecastCount& count, const Execution& execution);

} // namespace difusa
