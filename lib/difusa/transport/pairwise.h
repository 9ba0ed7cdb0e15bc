// Transport between pairs of sites (T 5.7): S_jk = V(x_j, x_k) F(x_j, x_k) A_k with a form-factor kernel. Costs
// #S (#S - 1) / 2 visibility segments and memory for every pair that sees each other.
//
// Nothing bounds the row sums: where sites are closer than the kernel allows, or the areas are too large, their sum
// exceeds 1 and the iteration may diverge. That is detected before solving (algebra/spectral_radius.h).
#pragma once

#include <difusa/discretisation/element_integrals.h>
#include <difusa/discretisation/site_set.h>
#include <difusa/rays/visibility.h>
#include <difusa/transport/kernel.h>
#include <difusa/transport/transport.h>

namespace difusa {

/// Areas are those of the sites; `integrals.share` tells which part of an element emits. `sky` and `back` are left
/// empty: pairs of sites cannot tell what escapes.
Transport pairwise(const Scene& scene, const SiteSet& sites, const ElementIntegrals& integrals,
                   const Visibility& visibility, const Kernel& kernel, const Execution& execution);

} // namespace difusa
