// Where the error of a solution is, and why: an estimate per point.
#pragma once

#include <difusa/core/types.h>
#include <difusa/radiosity/error_estimate.h>

#include <span>

namespace difusa {

/// Estimated errors at points, of the radiosity unless another quantity is named, of thermal scenes of the irradiation:
/// root mean squares over the channels: #x by 1, W/m².
struct ErrorsAt {
    ErrorsAt() = default;
    explicit ErrorsAt(std::size_t points);
    Values noise;          ///< of the rays cast from the sites, or for the point itself
    Values discretisation; ///< what the basis cannot represent; of gathered light, what bounces carry on to it
    Values error;          ///< of both, and of what bounces carry on from elsewhere
    Values irradiance;     ///< the error of the irradiance, also where nothing is reflected
};

/// The noise of a site follows from the variance of the light that its rays met: it is in proportion to it, with a
/// factor that the error points tell, and with what the projection makes of it. The rest of the residual is the
/// basis's: in proportion to how much the coefficients vary among the basis functions at a point, or of a piecewise
/// constant basis among neighbouring elements, with a factor from the error points around it. Where error points are
/// blind to errors of the irradiance, on surfaces that reflect nothing, the factors come from the points that judge the
/// irradiance instead (ErrorEstimate::of_irradiance).
class ErrorMap {
  public:
    /// Keeps references.
    ErrorMap(const Solution& solution, const ErrorEstimate& estimate, const Execution& execution);

    ErrorsAt at(std::span<const SurfacePoint> x, const Execution& execution) const;

    /// The same for what Field::at has found at the points.
    ErrorsAt of(std::span<const SurfacePoint> x, const PointValues& values, const Execution& execution) const;

    /// The same from errors of `at` or `put`: replaces those of the points whose light Field::at has gathered, and adds
    /// the noise of the light of sharp sources.
    void complete(std::span<const SurfacePoint> x, const PointValues& values, ErrorsAt& errors,
                  const Execution& execution) const;

    /// Adds noise of the light of sharp sources with this variance (Field::sharp).
    void add_sharp(std::span<const SurfacePoint> x, const Values& variance, ErrorsAt& errors) const;

    /// The same as `at` for a single point x, number i of them, where `row` is the basis slightly inside the face of x
    /// (Field). `errors` has room for it.
    void put(const SurfacePoint& x, const BasisRow& row, std::size_t i, ErrorsAt& errors) const;

    /// The same as `at` for light gathered at the points with so many rays (Field::at), with this noise of its
    /// radiosity and its irradiance (#x by 1, W/m², root mean squares over the channels). The noise is at least what
    /// the rays of the sites around let expect: few rays may all miss what is bright, such as a distant window, and
    /// then know nothing of their noise.
    ErrorsAt gathered_at(std::span<const SurfacePoint> x, std::size_t rays, const Values& noise,
                         const Values& noise_of_irradiance, const Execution& execution) const;

  private:
    struct Local;
    void put_gathered(std::span<const SurfacePoint> x, const PointValues& values, ErrorsAt& errors,
                      const Execution& execution) const;
    /// What error points tell of the rest: sums of the squares that are the basis's, and of the variation there.
    struct Fit {
        std::vector<double> ratio, seen; ///< #S: over the error points around an element
        double mean_ratio = 0.0, mean_seen = 0.0;
        double factor(const BasisRow& row) const;
    };
    Local local(const SurfacePoint& x, const BasisRow& row) const;
    double over_channels(double squares) const; ///< root of their mean
    // `rows`: the basis at the points of an estimate.
    double of_rays(const ErrorEstimate& told, const std::vector<BasisRow>& rows) const;
    double passed_on(const ErrorEstimate& told, const std::vector<BasisRow>& rows, const Execution& execution) const;
    Fit fit(const ErrorEstimate& told, const std::vector<BasisRow>& rows, bool of_irradiance) const;

    const Solution& solution_;
    const ErrorEstimate& estimate_;
    Rgb carried_ = Rgb::Zero(); ///< mean squares over the surface of what bounces carry on, with what is cut off
    Values noise_;              ///< #S by #channels: estimated variance of h, W²/m⁴
    Values coefficients_;       ///< #S by #channels: of h, all sets together
    Values variation_;          ///< #S by #channels: of h around elements of a piecewise constant basis; else empty
    Fit judged_, irradiance_;   ///< the latter empty without ErrorEstimate::of_irradiance
};

} // namespace difusa
