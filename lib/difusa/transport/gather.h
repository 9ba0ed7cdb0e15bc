// Transport in directional form (T 2.5): S_jk = sum_d w_d phi_k(x_j ↑ d), where x ↑ d is the first surface point that
// the ray from x along d meets. With a partition of unity the row sums are the share of rays that meet a front, so
// ‖S‖∞ <= 1 always. Costs #points times N first-hit rays; memory grows linearly in the number of points.
#pragma once

#include <difusa/discretisation/basis.h>
#include <difusa/lighting/first_bounce.h>
#include <difusa/rays/directions.h>
#include <difusa/rays/visibility.h>
#include <difusa/transport/transport.h>

#include <cstdint>
#include <span>

namespace difusa {

/// What is to be gathered besides what the surface reflects.
struct Sources {
    /// #materials, or empty: those whose emission is computed otherwise, so that it is not to come into L or `uneven`
    /// (DirectLight::lamp_materials).
    std::vector<char> lamps = {};
    /// Sharp sources whose light is wanted after one reflection: it is evaluated where rays hit, and at places drawn on
    /// bright surfaces (FirstBounce), with one shadow ray for each sun or point light and one for all lamps, so that no
    /// shadow is smoothed by a basis. One column set of Transport::bounce for each.
    std::vector<const FirstBounce*> bounce = {};
    int channels = 3; ///< of `bounce`
};

/// `points`: where irradiance is wanted, the rows of S. `rays`: directions asked for per point.
Transport gather(const Scene& scene, std::span<const SurfacePoint> points, const Basis& basis,
                 const Visibility& visibility, const Directions& directions, std::size_t rays, std::uint64_t seed,
                 const Execution& execution, const Sources& sources = {});

/// Only what escapes and what meets backs: Transport::sky, dome and back of a transport that was made without rays.
void gather_sky(const Scene& scene, std::span<const SurfacePoint> points, const Visibility& visibility,
                const Directions& directions, std::size_t rays, std::uint64_t seed, const Execution& execution,
                Transport& transport);

} // namespace difusa
