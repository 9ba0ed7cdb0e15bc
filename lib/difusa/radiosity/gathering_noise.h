// How far is off what is gathered with low-discrepancy rays? A few independent gathers tell by their scatter, but
// little: where few rays meet what is bright, as a window far away, all of them may meet it equally often, or never.
#pragma once

#include <difusa/core/types.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace difusa {

/// The expected variance of the sum of what low-discrepancy rays bring. `sum_squared`: the square of this sum;
/// `independent`: the variance that it would have if the rays were independent. If m of the rays meet one thing that is
/// bright, and the sum is H, that is H²/m. The rays of a lattice, one in each of as many equal cells, differ only in
/// the cells that its outline crosses, of which there are about 4 √m, by 1/6 of the square of a ray each: H² 2/3
/// m^(-3/2). With more that is bright, m is what the variance of independent rays tells.
inline double lattice_variance(double sum_squared, double independent) {
    if (!(independent > 0.0) || !(sum_squared > 0.0)) {
        return 0.0;
    }
    const double relative = independent / sum_squared; // 1/m
    return sum_squared * std::min(relative, 2.0 / 3.0 * relative * std::sqrt(relative));
}

/// The same as n rays tell it themselves. `squares`: the sum of the squares of what each brings. A single ray tells
/// nothing of its variance, which is then taken to be the square of what it brings.
inline double expected_variance(double sum_squared, double squares, std::size_t n) {
    const auto rays = static_cast<double>(n);
    return lattice_variance(sum_squared, n > 1 ? (squares - sum_squared / rays) * rays / (rays - 1.0) : squares);
}

/// The noise of means of independent gathers: #points by 1. `squares`: the estimated squares of the noise of the mean,
/// from so many `differences` (one less than gathers), summed over the channels; `expected`: its expected variance,
/// likewise, which counts as `prior` further differences, but never makes the noise less than its estimate.
inline Values noise_of_gathers(const Values& squares, int differences, const Values& expected) {
    constexpr double prior = 3.0;
    const Values both = (differences * squares + prior * expected) / (differences + prior);
    return squares.cwiseMax(both).cwiseSqrt();
}

} // namespace difusa
