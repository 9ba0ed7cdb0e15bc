// Does the light die out? The Neumann series of K diag(rho) converges exactly if its spectral radius is below 1.
#pragma once

#include <difusa/algebra/solver.h>

namespace difusa {

/// Estimate of the spectral radius of x -> K(rho ∘ x), the largest over the columns of `rho`, by `steps` steps of
/// Arnoldi's method from the constant vector (which is near the dominant eigenvector of a transport operator).
double spectral_radius(const LinearOperator& K, const Values& rho, int steps, const Execution& execution);

} // namespace difusa
