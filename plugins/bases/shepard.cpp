// Basis `shepard` (T 3.29, 4.10, 4.11): inverse powers of the site distance, normalised:
//     phi_i = w_i / sum_j w_j,   w_i(x) = ‖x,p_i‖^-k.
// It interpolates and is a partition of unity. As printed, every element extends everywhere; to be sparse it needs a
// finite support, here the radius r_i (the m-th neighbour). With `support=tapered` (the default) the weight goes to
// zero there, w_i = (1/‖x,p_i‖ - 1/r_i)^k (after Franke and Little), so that the field stays continuous;
// `support=sharp` truncates the printed formula, which leaves small jumps.
#include <difusa/discretisation/point_basis.h>
#include <difusa/plugin/plugin.h>

#include <algorithm>
#include <cmath>

namespace {

class Shepard final : public difusa::PointBasis {
  public:
    explicit Shepard(const difusa::Parameters& parameters)
        : k_(parameters.real("k")), width_(parameters.real("width")),
          tapered_(parameters.word("support") == "tapered") {}

    bool partition_of_unity() const override { return true; }
    bool coefficients_are_values() const override { return true; }
    bool interpolates() const override { return true; }

  protected:
    double support(double r) const override { return width_ * r; }

    void weigh(const difusa::SurfacePoint& /*x*/, const difusa::Neighbourhood& near,
               std::span<double> weight) const override {
        if (weight.empty()) {
            return;
        }
        // In units of one of the radii, so that the powers cannot overflow at any scale of the scene.
        const double unit = near.radius[0];
        bool at_site = false;
        for (std::size_t i = 0; i < weight.size(); ++i) {
            const double inverse_distance = near.cosine[i] * unit / near.distance[i];
            const double inverse_radius = unit / (width_ * near.radius[i]);
            at_site = at_site || !(inverse_distance < 1e60);
            const double excess = inverse_distance - inverse_radius;
            weight[i] = excess <= 0.0 ? 0.0 : tapered_ ? excess : inverse_distance;
        }
        if (at_site) { // the limit x -> p_i; coincident sites share it
            for (std::size_t i = 0; i < weight.size(); ++i) {
                weight[i] = near.cosine[i] * unit / near.distance[i] < 1e60 ? 0.0 : 1.0;
            }
        } else if (k_ == 2.0) {
            for (double& w : weight) {
                w *= w;
            }
        } else {
            for (double& w : weight) {
                w = std::pow(w, k_);
            }
        }
    }

  private:
    double k_, width_;
    bool tapered_;
};

} // namespace

DIFUSA_PLUGIN(basis, "shepard", Shepard, "Inverse distance weights: an interpolating partition of unity (T 4.10).",
              {{"k", difusa::ParameterSpec::Type::real, "2", "exponent of the inverse site distance", 0.25, 4.0, {}},
               {"width",
                difusa::ParameterSpec::Type::real,
                "1",
                "support radius as a multiple of the site's radius",
                0.05,
                20.0,
                {}},
               {"support",
                difusa::ParameterSpec::Type::word,
                "tapered",
                "how the weight ends at the support's radius",
                0,
                0,
                {"tapered", "sharp"}}})
