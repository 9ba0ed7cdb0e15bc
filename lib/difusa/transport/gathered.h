// Transport in directional form (T 2.5): D_js is the share of the rays of point j, cosine-weighted, that first meet the
// front of surfel s. Row sums of D and Y and the share that meets backs are together exactly 1, so ‖D‖∞ <= 1 always.
// Costs #points times N first-hit rays, and one or two bytes a ray.
#pragma once

#include <difusa/discretisation/surfels.h>
#include <difusa/rays/directions.h>
#include <difusa/rays/tracer.h>
#include <difusa/transport/light_transport.h>

#include <cstdint>
#include <span>

namespace difusa {

/// `points`: where irradiance is wanted. `rays`: directions asked for per point. Rows are HitLists where all directions
/// have the same weight, else SparseRows.
LightTransport gathered(const Tracer& tracer, std::span<const SurfacePoint> points, const Surfels& surfels,
                        const Directions& directions, std::size_t rays, std::uint64_t seed, const Execution& execution);

} // namespace difusa
