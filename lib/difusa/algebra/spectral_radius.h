// Does the light die out? The Neumann series of T converges if and only if its spectral radius is below 1.
#pragma once

#include <difusa/algebra/linear_operator.h>

namespace difusa {

/// Estimate of the spectral radius of the square operator T, which acts on one column, by at most `steps` steps of the
/// Arnoldi iteration; ends early when four estimates in a row agree within `tolerance`, relative. It starts from a
/// constant vector, which is close to the dominant eigenvector of a transport operator, with noise added: from the
/// constant alone it would settle before it finds larger eigenvalues that belong to a few unknowns, such as those in a
/// gap. Where the estimate is within 0.001 of 1 the constant is tried by itself, too: where nothing is absorbed it is
/// an eigenvector, and the radius is exact.
double spectral_radius(const LinearOperator& T, int steps, double tolerance, const Execution& execution);

} // namespace difusa
