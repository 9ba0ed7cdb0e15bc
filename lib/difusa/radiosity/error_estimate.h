// How accurate is a solution? Its own equation tells. With the light h~ that the coefficients represent, the residual
//     r(x) = rho(x) (h(x; h~) - h~(x)),   h(.; h~) gathered from h~ with fresh rays,
// is measured at random surface points. The error e of the radiosity, with the transport operator K, is
//     e = r + rho K e = r + p,   p = rho K (1 - rho K)^-1 r,
// where p, the part that bounces carry on, comes from a solve of the system itself with the measured residuals as
// emitters. Squares are products of two independent measurements, so that the noise of neither counts as error. The
// noise of directly evaluated light adds to e where it is displayed, and is carried nowhere.
//
// Besides this estimate there is a bound: with rho_max < 1 the largest reflectance, ‖e‖ <= ‖r‖ / (1 - rho_max), because
// K has norm 1 at most (its kernel is symmetric and its row sums are at most 1).
//
// Of thermal scenes the irradiation is judged instead (judged_weights): r without the factor rho, p without the first
// one, and the bound is the same, ‖r‖ + ‖K rho e‖ <= ‖r‖ / (1 - rho_max).
#pragma once

#include <difusa/radiosity/error_points.h>
#include <difusa/radiosity/rms_interval.h>

#include <memory>
#include <vector>

namespace difusa {

struct ErrorEstimate {
    std::size_t points = 0, rays = 0, segments = 0; ///< surface points; rays and segments cast in all
    double reflected = 0.0; ///< rms of B - E, W/m²: what errors are told relative to, since the brightness of a lamp
                            ///< says nothing about the light on the walls; of thermal scenes that of H, the difference
                            ///< of the irradiation to that at the reference temperature

    RmsEstimate total;            ///< error of the radiosity, at most what the residual allows
    RmsEstimate indirect;         ///< of its part rho H_indirect
    RmsEstimate residual;         ///< r, with the noise of direct light
    RmsEstimate carried_rms;      ///< p
    double noise_of_direct = 0.0; ///< rms of `total`'s part that shadow rays leave, which no other rays remove
    double cut_off = 0.0; ///< of `residual`, what light that is cut off leaves (cut_off_coefficients); no ray helps

    double largest_reflectance = 0.0; ///< rho_max (function `largest_reflectance`)
    double noise = 0.0;               ///< of a gathered output: of its noise, as RmsEstimate; else 0
    double bound = 0.0; ///< residual.high / (1 - rho_max), W/m²; infinite if some surface absorbs nothing

    // What was measured, to be spread over the surface (error_map.h):
    ErrorPoints at;
    std::vector<double> squared; ///< unbiased estimates of |r|², may be negative, without the noise of directly
                                 ///< evaluated light, which `residual` and `total` include; W²/m⁴
    std::vector<double> spread; ///< of the variance of one gather of h by surfels there (Field::gather_by_surfels) with
                                ///< `rays_per_gather` rays, all channels; W²/m⁴
    std::vector<std::size_t> rays_per_gather; ///< #points
    Values cut_off_light;                     ///< cut_off_coefficients; no rows: no light is cut off
    Values carried;                           ///< #S by #channels: coefficients of p / rho, W/m²

    /// Where the points are blind to errors of the irradiance (ErrorPointSampler::is_blind): `at`, `squared`, `spread`
    /// and `rays_per_gather` at others, drawn as if all surfaces were white, for the irradiance itself; all else is
    /// empty. Otherwise null.
    std::shared_ptr<const ErrorEstimate> of_irradiance;
};

/// Points that are measured first, at most.
inline constexpr std::size_t few_error_points = std::size_t{20} * ErrorPoints::groups;

/// When an error is measured again.
struct FurtherRounds {
    /// Each with more rays at the same points, with as many other points, or with more points for direct light alone,
    /// whichever leaves most of the doubt; 0: never. All that was measured counts.
    std::size_t most = 2;
    /// A limit for the upper end, over `reflected`; 0: none. Without one, errors are measured again while the upper end
    /// is far above the estimate. With one, they are while it is above the limit and half of the doubt less would bring
    /// it below, always with more rays. Who stops at the first upper end below a limit has up to three chances, so that
    /// it holds a little less often than in 97.5 % of cases.
    double limit = 0.0;
};

/// Measures at about `points` points with twice `rays` rays each, and solves once; then again, if need be. Without a
/// limit, and unless errors are never measured again, a few points are measured first: where the noise of so few rays
/// is large beside the residuals, fewer points with more rays each, about as many in all, leave less doubt.
ErrorEstimate estimate_error(const Solution& solution, std::size_t points, std::size_t rays, std::uint64_t seed,
                             const FurtherRounds& further, const Execution& execution);

/// The same for the light gathered at points from this solution: e = p, plus the noise of the gathering (rms over the
/// area, W/m²), all of which counts as error of the indirect light too.
void judge_gathered(ErrorEstimate& estimate, double noise);

} // namespace difusa
