// Transport in directional form (T 2.5): S_jk = sum_d w_d phi_k(x_j ↑ d), where x ↑ d is the first surface point that
// the ray from x along d meets. With a partition of unity the row sums are the share of rays that meet a front, so
// ‖S‖∞ <= 1 always. Costs #points times N first-hit rays; memory grows linearly in the number of points.
#pragma once

#include <difusa/basis/basis.h>
#include <difusa/lighting/direct_light.h>
#include <difusa/transport/directions.h>
#include <difusa/transport/transport.h>
#include <difusa/visibility/visibility.h>

#include <cstdint>
#include <span>

namespace difusa {

/// Light of sharp sources that reaches a point after one reflection, gathered with the rays of the transport: it is
/// evaluated where they hit, with one shadow ray for each source, so that no shadow is smoothed by a basis.
struct FirstBounce {
    const DirectLight* light = nullptr;
    int channels = 3;
};

/// `points`: where irradiance is wanted, the rows of S. `rays`: directions asked for per point. The emission of faces
/// goes into L, unless `bounce` has lamps: then DirectLight accounts for it. With `bounce` Transport::bounce is filled.
Transport gather(const Scene& scene, std::span<const SurfacePoint> points, const Basis& basis,
                 const Visibility& visibility, const Directions& directions, std::size_t rays, std::uint64_t seed,
                 const Execution& execution, const FirstBounce* bounce = nullptr);

/// Only what escapes and what meets backs: Transport::sky and Transport::back of a transport that was made without
/// rays.
void gather_sky(const Scene& scene, std::span<const SurfacePoint> points, const Visibility& visibility,
                const Directions& directions, std::size_t rays, std::uint64_t seed, const Execution& execution,
                Transport& transport);

} // namespace difusa
