// Transport in directional form (T 2.5): D_js is the cosine-weighted share of the rays of point j that first hit the
// front of surfel s. The row sums of D and Y and the share that hits backs add up to exactly 1, so ‖D‖∞ <= 1 always.
// Costs #points times N first-hit rays, and one or two bytes per ray.
#pragma once

#include <difusa/discretisation/surfels.h>
#include <difusa/rays/directions.h>
#include <difusa/rays/tracer.h>
#include <difusa/transport/light_transport.h>

#include <cstdint>
#include <functional>
#include <span>

namespace difusa {

/// How the sky is divided: number of parts, and the part that contains a unit direction.
struct SkyBins {
    Index count = 0;
    std::function<Index(const Vec3& towards)> at;
};

/// `points`: where irradiance is needed. `rays`: requested directions per point. Rows are HitLists if all directions
/// have the same weight, otherwise SparseRows.
LightTransport gathered(const Tracer& tracer, std::span<const SurfacePoint> points, const Surfels& surfels,
                        const Directions& directions, std::size_t rays, std::uint64_t seed, const Execution& execution);

/// The same rays, sorted into other parts of the sky than those of scene/sky_parts.h.
LightTransport gathered(const Tracer& tracer, std::span<const SurfacePoint> points, const Surfels& surfels,
                        const SkyBins& sky, const Directions& directions, std::size_t rays, std::uint64_t seed,
                        const Execution& execution);

} // namespace difusa
