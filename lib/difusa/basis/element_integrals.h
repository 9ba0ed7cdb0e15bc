// Integrals of basis elements over the surface.
#pragma once

#include <difusa/basis/basis.h>
#include <difusa/scene/scene.h>
#include <difusa/transport/sparse_rows.h>

#include <vector>

namespace difusa {

struct ElementIntegrals {
    std::vector<double> area; ///< #S: A_i = ∫ phi_i dA (T 5.3); for a partition of unity they sum to the surface's area
    SparseRows share;         ///< #S by #materials that emit: ∫_{faces of material m} phi_i pattern dA / A_i
    double uncovered = 0.0;   ///< area on which no element lives (not a partition of unity), as found by the same rule
};

/// By the midpoint rule on triangles halved until no edge is longer than `spacing` / 2. Every element has a positive
/// area unless its support falls between the nodes; then it is 0. Memory for `share` only if some material emits.
ElementIntegrals element_integrals(const Scene& scene, const Basis& basis, double spacing, const Execution& execution);

} // namespace difusa
