// Surface points where the error of a solution is measured: more of them where it may be large.
#pragma once

#include <difusa/discretisation/facing_distance.h>
#include <difusa/radiosity/surfel_points.h>
#include <difusa/radiosity/system.h>

#include <cstdint>
#include <vector>

namespace difusa {

/// The weights of the points sum to the area where errors count (judged_weights).
struct ErrorPoints : SurfelPoints {
    /// The variance over the rays of each point of the system (Discretisation::points) of the light they meet, to which
    /// their noise is in proportion: #points of the system by #channels, W²/m⁴; rays count by their weights. 0 for
    /// transport without rays, and for fixed directions, whose errors are not noise (Directions::is_fixed).
    Values variance;

    /// The same of what fresh rays meet there: without exact form factors, unless they are corrected by these
    /// (radiosity/exact_correction.h).
    Values variance_of_fresh;

    static constexpr Index groups = 7; ///< odd
};

/// Where the error of a solution may be large: #surfels by #channels.
struct ErrorSources {
    Values light;             ///< that the coefficients represent, W/m²
    Values variation;         ///< variance of the coefficients among the basis functions there, because the error of an
                              ///< approximation grows with the variation of what it approximates; W²/m⁴
    Values noise;             ///< ErrorPoints::variance around; W²/m⁴
    Values shadowed;          ///< square of the direct light where it is uneven and lights cast penumbras, which are
                              ///< narrow: else 0; W²/m⁴
    Values variance;          ///< ErrorPoints::variance
    Values variance_of_fresh; ///< ErrorPoints::variance_of_fresh
};

/// What an error of the irradiance of a surfel counts as in what is judged, #surfels by #channels: rho, since the
/// radiosity is. In thermal scenes 1: the irradiation itself is judged, from which net fluxes and temperatures follow.
Values judged_weights(const Solution& solution);

/// The same at a point.
Rgb judged_weight(const Scene& scene, const SurfacePoint& x);

/// The largest diffuse reflectance of the scene, over faces and channels; that of a partial mirror or glossy surface,
/// which reflects the share s specularly, counts as rho / (1 - s), so that it bounds the norm of transport over these,
/// too: if what is seen there sends back at most the share F, the surface sends back at most rho + s F, which is F at
/// most if F >= rho / (1 - s).
double largest_reflectance(const Scene& scene, int channels);

/// The irradiance that light which is cut off (LightTransport::cut_off) would bring if it were as bright as what the
/// surface receives on average, as coefficients of the basis: #S by #channels, W/m²; no rows if none is cut off. No
/// residual tells of it, since fresh rays are cut off alike.
Values cut_off_coefficients(const Solution& solution, const Execution& execution);

ErrorSources error_sources(const Solution& solution, const Execution& execution);

/// Draws error points of a solution by a density, which is a mixture divided by a distance. The mixture: in equal parts
/// in proportion to w², with which the square of an error of the irradiance counts (w = judged_weights or 1), and to w²
/// times the square of ErrorSources::light, times its variation, and times its noise. The distance is that to what the
/// point faces (discretisation/facing_distance.h), but at least a twentieth of the spacing and at most all of it: where
/// walls meet floors, errors are large in strips narrower than any element, which the coefficients do not tell of. The
/// distance is computed at 16 candidates for each point, from which the points are chosen.
class ErrorPointSampler {
  public:
    enum class Of { what_is_judged, irradiance };

    /// Keeps references to both.
    ErrorPointSampler(const Solution& solution, const Execution& execution, Of errors = Of::what_is_judged);

    /// Whether hardly any of the noise of rays, or of the variation of the coefficients, is where points are drawn:
    /// what is measured there then tells nothing of the errors of the irradiance elsewhere. A floor between black walls
    /// receives none of the light that it sends to them, and none of the noise of their rays.
    bool is_blind() const;

    /// `count` points, rounded up to a multiple of the groups: one of each group from each of as many equal shares of
    /// the density as there are points in a group. None if nothing reflects.
    ErrorPoints draw(std::size_t count, std::uint64_t seed) const;

  private:
    const Surfels& surfels_;
    const Execution& execution_;
    Values weights_; ///< w, #surfels by #channels
    ErrorSources sources_;
    std::vector<double> density_; ///< the mixture's integral over each surfel
    double area_ = 0.0;           ///< of the surfels where it is not 0
    FacingDistance facing_;
};

/// About `count` of the points, as many of each group, in equal steps through the order of the points from a random
/// start; all if there are no more. The weights sum to the same area.
ErrorPoints fewer_points(const ErrorPoints& points, std::size_t count, RandomStream& stream);

} // namespace difusa
