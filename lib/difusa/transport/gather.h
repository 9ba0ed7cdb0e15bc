// Transport in directional form (T 2.5): S_jk = sum_d w_d phi_k(x_j ↑ d), where x ↑ d is the first surface point that
// the ray from x along d meets. With a partition of unity the row sums are the share of rays that meet a front, so
// ‖S‖∞ <= 1 always. Costs #S times N first-hit rays; memory grows linearly in the number of sites.
#pragma once

#include <difusa/basis/basis.h>
#include <difusa/sites/site_set.h>
#include <difusa/transport/directions.h>
#include <difusa/transport/transport.h>
#include <difusa/visibility/visibility.h>

#include <cstdint>

namespace difusa {

/// `rays`: directions asked for per site. The basis must be bound to `sites`.
Transport gather(const Scene& scene, const SiteSet& sites, const Basis& basis, const Visibility& visibility,
                 const Directions& directions, std::size_t rays, std::uint64_t seed, const Execution& execution);

/// Only what escapes and what meets backs: Transport::sky and Transport::back of a transport that was made without
/// rays.
void gather_sky(const SiteSet& sites, const Visibility& visibility, const Directions& directions, std::size_t rays,
                std::uint64_t seed, const Execution& execution, Transport& transport);

} // namespace difusa
