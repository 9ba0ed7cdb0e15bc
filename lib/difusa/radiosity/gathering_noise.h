// How far is off what is gathered with low-discrepancy rays? A few independent gathers tell by their scatter, but
// little: where few rays meet what is bright, as a window far away, all of them may meet it equally often, or never.
#pragma once

#include <difusa/core/types.h>

#include <algorithm>
#include <cmath>

namespace difusa {

/// The expected noise (standard deviation) of a sum H over low-discrepancy rays that would have this variance if the
/// rays were independent. If m of the rays meet one thing that is bright, independent rays have the variance H²/m.
/// Those of a lattice, one in each of as many equal cells, differ only in the cells that its outline crosses, of which
/// there are about 4 √m, by 1/6 of the square of a ray each: H² 2/3 m^(-3/2). With more that is bright, m is what the
/// variance tells: H² / variance.
inline double expected_noise(double variance, double H) {
    if (!(variance > 0.0) || !(H > 0.0)) {
        return 0.0;
    }
    const double relative = variance / (H * H); // 1/m
    return H * std::sqrt(std::min(relative, 2.0 / 3.0 * relative * std::sqrt(relative)));
}

/// The noise of means of independent gathers: #points by 1. `squares`: the estimated squares of the noise of the mean,
/// from so many `differences` (one less than gathers), summed over the channels; `variance`: of the mean, if all rays
/// were independent; `H`: the mean, #points by #channels. The expected noise counts as `prior` further differences, but
/// never makes the noise less than its estimate.
inline Values noise_of_gathers(const Values& squares, int differences, const Values& variance, const Values& H) {
    constexpr double prior = 3.0;
    Values noise(squares.rows(), 1);
    for (Eigen::Index i = 0; i < noise.rows(); ++i) {
        const double expected = expected_noise(variance(i, 0), H.row(i).norm());
        const double both = (differences * squares(i, 0) + prior * expected * expected) / (differences + prior);
        noise(i, 0) = std::sqrt(std::max(squares(i, 0), both));
    }
    return noise;
}

} // namespace difusa
