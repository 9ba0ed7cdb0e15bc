// Form factors of a closed surface, corrected so that all four laws hold to rounding.
#pragma once

#include <difusa/form_factors/form_factors.h>

#include <string>
#include <vector>

namespace difusa {

/// By how much factors were changed.
struct ClosureCorrection {
    double largest = 0.0;          ///< max |change of F_ij|
    double largest_relative = 0.0; ///< max |change of F_ij| / F_ij
    double rms_relative = 0.0;     ///< the same, weighted with the exchange areas
    double row_sum_error = 0.0;    ///< max |sum_j F_ij - 1| afterwards
};

/// The nearest exchange areas X to G_ij = A_i F_ij (the mean of both directions) with
///     sum_j X_ij = A_i,   X_ij = X_ji,   X_ij >= 0,   in the norm   sum_ij (X_ij - G_ij)² / G_ij:
/// with multipliers, X_ij = G_ij (1 + l_i + l_j), where (diag(sum_j G_ij) + G) l = A - G 1 is solved by conjugate
/// gradients. Zeros stay zeros. Entries that would become negative are set to 0, and the others solved for again.
///
/// `names` of the surfaces are for messages; without them, surfaces are named by their numbers.
///
/// Throws InputError if some row sum is farther than `largest_gap` from 1: what escapes from an open surface is no
/// error; NotConverged if no such X is found.
ClosureCorrection enforce_closure(FormFactors& F, const std::vector<std::string>& names = {},
                                  double largest_gap = 0.05);

} // namespace difusa
