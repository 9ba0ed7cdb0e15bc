// Points that fill a unit square or cube evenly for any number of points.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace difusa {

/// The fractional part of x, in [0, 1) for x not too large to have one.
inline double fraction(double x) {
    return x - std::floor(x);
}

/// For N = 2 to 5: powers of 1/g, where g is the root above 1 of g^(N+1) = g + 1.
template <std::size_t N> constexpr std::array<double, N> even_steps = {};
template <> inline constexpr std::array<double, 2> even_steps<2>{0.7548776662466927, 0.5698402909980532};
template <>
inline constexpr std::array<double, 3> even_steps<3>{0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
template <>
inline constexpr std::array<double, 4> even_steps<4>{0.85667488385450286, 0.73389185662712597, 0.62870672103780856,
                                                     0.53859725722360996};
template <>
inline constexpr std::array<double, 5> even_steps<5>{0.88127146163356959, 0.77663938908976812, 0.68443012958534251,
                                                     0.60316874068572824, 0.53155539771579124};

/// Point i, from 0, of the sequence in [0, 1)^N that starts at `shift`: the fractional parts of shift + i / g^k
/// (Roberts 2018, the additive recurrence R_N).
template <std::size_t N> std::array<double, N> even_point(std::size_t i, const std::array<double, N>& shift) {
    std::array<double, N> u = shift;
    for (std::size_t k = 0; k < N; ++k) {
        u[k] = fraction(shift[k] + static_cast<double>(i) * even_steps<N>[k]);
    }
    return u;
}

} // namespace difusa
