// The solution of the radiosity equation for any right-hand sides, and of its transpose.
#pragma once

#include <difusa/radiosity/system.h>

namespace difusa {

/// Columns of right-hand sides that are solved for together: the more columns, the less time each takes, as far as
/// memory goes. `transposed`: with products by the transpose, which need more of it.
Eigen::Index columns_at_once(const LightTransport& transport, bool transposed = false);

/// h = g + T h with T = D diag(rho) P Π. `reflectance`: #surfels by #channels; `g`: #points by any number of columns,
/// of which column c is reflected by channel c modulo #channels. Solved `columns_at_once` at a time, with the solver of
/// the system: with krylov each column has the bits that it has alone. Throws NotConverged.
Values solve_for(const RadiositySystem& system, const Values& reflectance, const Values& g, const SolveOptions& options,
                 const Execution& execution);

/// x = g + Tᵀ x, likewise. Throws UsageError for a solver that relaxes one unknown after the other.
Values solve_transpose_for(const RadiositySystem& system, const Values& reflectance, const Values& g,
                           const SolveOptions& options, const Execution& execution);

} // namespace difusa
