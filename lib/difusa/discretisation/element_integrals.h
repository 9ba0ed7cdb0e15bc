// Integrals of basis elements over the surface.
#pragma once

#include <difusa/algebra/sparse_rows.h>
#include <difusa/discretisation/basis.h>
#include <difusa/scene/scene.h>

#include <array>
#include <vector>

namespace difusa {

struct ElementIntegrals {
    std::vector<double> area; ///< #S: A_i = ∫ phi_i dA (T 5.3); for a partition of unity they sum to the surface's area
    SparseRows share;         ///< #S by #materials that emit evenly: ∫_{faces of material m} phi_i dA / A_i
    std::array<SparseRows, 3>
        uneven;         ///< for each channel, #S by #materials that do not: ∫ phi_i E dA / A_i; without rows if none
    Values reflectance; ///< #S by 3: ∫ phi_i rho dA / A_i; empty if no material has a reflectance texture
    double uncovered = 0.0; ///< area on which no element lives (not a partition of unity), as found by the same rule
};

/// By the midpoint rule on triangles halved until no edge is longer than `spacing` / 2. Every element has a positive
/// area unless its support falls between the nodes; then it is 0. Memory for `share` only if some material emits.
ElementIntegrals element_integrals(const Scene& scene, const Basis& basis, double spacing, const Execution& execution);

} // namespace difusa
