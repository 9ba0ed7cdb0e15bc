// Does the light die out? The Neumann series of T converges if and only if its spectral radius is below 1.
#pragma once

#include <difusa/algebra/linear_operator.h>

namespace difusa {

/// Estimate of the spectral radius of the square operator T, which acts on one column, by at most `steps` steps of the
/// Arnoldi iteration from the constant vector (close to the dominant eigenvector of a transport operator); ends early
/// when four estimates in a row agree within `tolerance`, relative.
double spectral_radius(const LinearOperator& T, int steps, double tolerance, const Execution& execution);

} // namespace difusa
