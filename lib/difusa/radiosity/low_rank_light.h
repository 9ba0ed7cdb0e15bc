// The light of later reflections as an operator of low rank: it is smooth, whatever lamps and suns make.
#pragma once

#include <difusa/radiosity/system.h>

#include <cstdint>
#include <vector>

namespace difusa {

/// Root mean squares over the area of the surface, of values at the points where light is gathered and on the surfels.
class AreaNorms {
  public:
    explicit AreaNorms(const Discretisation& discretisation);

    /// Of each column, in its unit.
    std::vector<double> of_points(const Values& h) const;
    std::vector<double> of_surfels(const Values& b) const;

    /// Square roots of the shares of the area: of the site that a point is, or equal ones if there are further points;
    /// and of the surfels.
    const Eigen::VectorXd& points() const { return points_; }
    const Eigen::VectorXd& surfels() const { return surfels_; }

  private:
    Eigen::VectorXd points_, surfels_;
};

/// How a factorisation of low rank is found.
struct LowRankOptions {
    std::size_t rank = 64;
    std::size_t more = 16;  ///< directions explored beyond the rank, and discarded afterwards
    int bounces = 1;        ///< m below
    std::uint64_t seed = 1; ///< of the random directions
    SolveOptions solve = {};
};

/// U Vᵀ near L = (I - T)^-1 T^m D, which takes the radiosity of the surfels to the irradiance that it causes at the
/// points after m further reflections and more.
struct LowRankLight {
    Values U, V;                         ///< #points and #surfels by rank
    std::vector<double> singular_values; ///< of U Vᵀ, descending, in the norms of AreaNorms
    /// rms(L b - U Vᵀ b) <= error rms(b) for all b, except with probability `low_rank_risk`.
    double error = 0.0;
};

inline constexpr double low_rank_risk = 0x1p-20;

/// Of each channel of `reflectance` (#surfels by #channels), by the randomised singular value decomposition of N.
/// Halko, P. Martinsson and J. Tropp ("Finding structure with randomness", SIAM Review 53(2), 2011, algorithms 4.1 and
/// 5.1) in the norms of AreaNorms. Products with L and Lᵀ are solutions of the equation and of its transpose for many
/// right-hand sides at once.
///
/// The error: for B = L - U Vᵀ and Gaussian vectors x_1 ... x_r, ‖B‖^5 = ‖(B Bᵀ)² B‖ is at most
/// a sqrt(2/pi) max_i ‖(B Bᵀ)² B x_i‖ except with probability a^-r (their lemma 4.1); r = 10 and a = 4. It is as
/// accurate as the solutions are.
///
/// Throws UsageError if rank + more exceed the number of points or the solver cannot solve the transposed equation, and
/// NotConverged.
std::vector<LowRankLight> low_rank_light(const RadiositySystem& system, const Values& reflectance,
                                         const LowRankOptions& options, const Execution& execution);

} // namespace difusa
