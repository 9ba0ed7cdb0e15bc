// Basis `radial` (T 4.6, 4.7): phi_i(x) = Psi(‖x,p_i‖), a Gaussian exp(-½ (d/s_i)²), zero beyond 4 s_i, with s_i =
// width r_i (r_i at most its median: in narrow places and near edges the m-th neighbour is far away, and wide elements
// on sites spaced as densely as elsewhere are nearly indistinguishable); or (T 4.8) the cubic substitute K(t) = 2t³ -
// 3t² + 1 of the same width at half height, which ends at 2.3548 s_i. Neither a partition of unity nor interpolating:
// coefficients require a solve. The dissertation's s_i = r_i is `width=1`; its elements overlap so much that the
// interpolation matrix is ill-conditioned. Above the default width the transport may amplify oscillations of the
// coefficients near edges until its series diverges; below it there are dips between the sites. The cubic is not
// positive definite and oscillates sooner. A bake detects all of this and refuses.
#include <difusa/discretisation/point_basis.h>
#include <difusa/plugin/plugin.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace {

// Ratio of the cubic's support to the Gaussian's s at equal half width: K(1/2) = 1/2 = exp(-½ (sqrt(2 ln 2))²).
constexpr double cubic_reach = 2.354820045030949;
constexpr double gaussian_reach = 4.0;

class Radial final : public difusa::PointBasis {
  public:
    explicit Radial(const difusa::Parameters& parameters)
        : width_(parameters.real("width")), cubic_(parameters.word("profile") == "cubic") {}

    bool partition_of_unity() const override { return false; }
    bool coefficients_are_values() const override { return false; }

  protected:
    void prepare(const difusa::SiteSet& sites) override {
        std::vector<double> radius = sites.radius;
        const auto middle = radius.begin() + static_cast<std::ptrdiff_t>(radius.size() / 2);
        std::nth_element(radius.begin(), middle, radius.end());
        median_ = *middle;
    }

    double support(double r) const override { return (cubic_ ? cubic_reach : gaussian_reach) * s(r); }

    void weigh(const difusa::SurfacePoint& /*x*/, const difusa::Neighbourhood& near,
               std::span<double> weight) const override {
        for (std::size_t i = 0; i < weight.size(); ++i) {
            const double d = near.distance[i] / (near.cosine[i] * s(near.radius[i])); // ‖x,p_i‖ / s_i
            if (cubic_) {
                const double t = d / cubic_reach;
                weight[i] = t < 1.0 ? 1.0 + t * t * (2.0 * t - 3.0) : 0.0;
            } else {
                weight[i] = d < gaussian_reach ? std::exp(-0.5 * d * d) : 0.0;
            }
        }
    }

  private:
    double s(double r) const { return width_ * std::min(r, median_); }

    double width_;
    double median_ = 0.0;
    bool cubic_;
};

} // namespace

DIFUSA_PLUGIN(
    basis, "radial", Radial, "Gaussian bells whose coefficients require a solve (T 4.6).",
    {{"width", difusa::ParameterSpec::Type::real, "0.4", "s_i as a multiple of the site's radius", 0.05, 20.0, {}},
     {"profile", difusa::ParameterSpec::Type::word, "gaussian", "the mother function", 0, 0, {"gaussian", "cubic"}}})
