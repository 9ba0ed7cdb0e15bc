// Transport between pairs of sites (T 5.7): a surfel's radiosity is distributed to the basis functions that cover it,
// and each of these acts as a patch at its site, with a form-factor kernel:
//     D = S M,   S_jk = V(x_j, x_k) F(x_j, x_k) A_k,   M_ks = (P_sk / sigma_s) A_s / A_k,   sigma_s = sum_i P_si.
// The whole surfel is distributed exactly once, even if the basis is not a partition of unity and sigma is not 1.
// Costs #S (#S - 1) / 2 visibility segments, and memory for every mutually visible pair.
//
// Nothing bounds the row sums: where sites are closer than the kernel allows, or the areas are too large, they exceed 1
// and the iteration may diverge. That is detected before solving (algebra/spectral_radius.h).
#pragma once

#include <difusa/discretisation/discretisation.h>
#include <difusa/rays/directions.h>
#include <difusa/rays/tracer.h>
#include <difusa/transport/kernel.h>
#include <difusa/transport/light_transport.h>

namespace difusa {

/// Areas are those of the sites. Pairs of sites cannot measure what escapes: `rays` rays from each site do that.
LightTransport pairwise(const Tracer& tracer, const Discretisation& discretisation, const Kernel& kernel,
                        const Directions& directions, std::size_t rays, std::uint64_t seed, const Execution& execution);

} // namespace difusa
