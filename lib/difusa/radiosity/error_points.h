// Surface points where the error of a solution is measured: more of them where it may be large.
#pragma once

#include <difusa/radiosity/system.h>

#include <cstdint>
#include <vector>

namespace difusa {

/// Random points with weights w_p: sum_p w_p f(x_p) estimates ∫ f dA for any f that vanishes where nothing is
/// reflected; the weights sum to the area where something is.
struct ErrorPoints {
    std::vector<SurfacePoint> place;
    std::vector<double> weight; ///< area
    std::vector<Index> surfel;  ///< each is on
    std::vector<Index> group;   ///< each belongs to: of `groups` of equal size, independent of each other

    /// The variance over the rays of each point of the system (Discretisation::points) of the light they meet, to which
    /// their noise is in proportion: #points of the system by #channels, W²/m⁴; 0 for transport without rays.
    Values variance;

    static constexpr Index groups = 3;

    std::size_t size() const { return place.size(); }
};

/// `count` points, rounded up to a multiple of the groups: one of each group from each of as many equal shares of a
/// density over the surfels as there are points in a group. The density is a mixture: in equal parts in proportion to
/// rho², with which the square of an error of the irradiance counts in the radiosity; to rho² times the variance of the
/// coefficients among the basis functions there, because the error of an approximation grows with the variation of what
/// it approximates; and to rho² times the variance over the rays of the sites, which makes their noise (zero for
/// transport without rays). None if nothing reflects.
ErrorPoints draw_error_points(const Solution& solution, std::size_t count, std::uint64_t seed,
                              const Execution& execution);

} // namespace difusa
