// Transport between pairs of sites (T 5.7): a surfel's radiosity is distributed to the basis functions that cover it,
// and each of these acts as a patch at its site, with a form-factor kernel:
//     D = S M,   S_jk = V(x_j, x_k) F(x_j, x_k) A_k,   M_ks = (P_sk / sigma_s) A_s / A_k,   sigma_s = sum_i P_si.
// The whole surfel is distributed exactly once, even if the basis is not a partition of unity and sigma is not 1.
// Over mirrors, S has what paths over mirror patches carry besides (transport/mirror_patches.h).
// Costs #S (#S - 1) / 2 visibility segments, and memory for every mutually visible pair.
//
// Nothing bounds the row sums: where sites are closer than the kernel allows, or the areas are too large, they exceed 1
// and the iteration may diverge. That is detected before solving (algebra/spectral_radius.h).
#pragma once

#include <difusa/algebra/sparse_rows.h>
#include <difusa/discretisation/discretisation.h>
#include <difusa/rays/directions.h>
#include <difusa/rays/tracer.h>
#include <difusa/transport/kernel.h>
#include <difusa/transport/light_transport.h>
#include <difusa/transport/mirror_patches.h>

#include <memory>

namespace difusa {

/// Areas are those of the sites. Pairs of sites cannot measure what escapes: `rays` rays from each site do that, over
/// mirrors too. Throws UsageError if mirrors have different reflectances for the channels.
LightTransport pairwise(const Tracer& tracer, const Discretisation& discretisation, const Kernel& kernel,
                        const MirrorPathOptions& over_mirrors, const Directions& directions, std::size_t rays,
                        std::uint64_t seed, const Execution& execution);

/// What of a pairwise transport comes from rays and pairs. The rest follows from the discretisation.
struct PairwiseParts {
    std::shared_ptr<const SparseRows> form_factors; ///< S, #S by #S; null if the transport is not pairwise
    std::shared_ptr<const LinearOperator> gathered; ///< of which the columns of the sky are used
};
PairwiseParts pairwise_parts(const LinearOperator& W);

/// M of a pairwise transport: #S by #surfels.
SparseRows pairwise_distribution(const LinearOperator& W);

/// W = [S M, Y], with Y from `gathered`.
std::shared_ptr<const LinearOperator> pairwise_operator(std::shared_ptr<const SparseRows> S,
                                                        std::shared_ptr<const LinearOperator> gathered,
                                                        const Discretisation& discretisation,
                                                        const Execution& execution);

} // namespace difusa
