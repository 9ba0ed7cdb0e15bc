// Basis `normalized-radial` (T 3.28, 4.9): phi_i = Psi_i / sum_j Psi_j with
//     Psi_i(x) = K(|x - p_i| / (width r_i)) max(0, n_x·n_i),   K(t) = 2t³ - 3t² + 1 on [0,1].
// A partition of unity that smooths: with the values at the sites as coefficients it is a quasi-interpolant, bounded by
// its data.
#include <difusa/discretisation/point_basis.h>
#include <difusa/plugin/plugin.h>

namespace {

class NormalizedRadial final : public difusa::PointBasis {
  public:
    explicit NormalizedRadial(const difusa::Parameters& parameters) : width_(parameters.real("width")) {}

    bool partition_of_unity() const override { return true; }
    bool coefficients_are_values() const override { return true; }

  protected:
    double support(double r) const override { return width_ * r; }

    void weigh(const difusa::SurfacePoint& /*x*/, const difusa::Neighbourhood& near,
               std::span<double> weight) const override {
        for (std::size_t i = 0; i < weight.size(); ++i) {
            const double t = near.distance[i] / (width_ * near.radius[i]);
            weight[i] = (1.0 + t * t * (2.0 * t - 3.0)) * near.cosine[i];
        }
    }

  private:
    double width_;
};

} // namespace

DIFUSA_PLUGIN(basis, "normalized-radial", NormalizedRadial,
              "Normalised cubic bell: a smoothing partition of unity (T 4.9).",
              {{"width",
                difusa::ParameterSpec::Type::real,
                "1",
                "support radius as a multiple of the site's radius",
                0.05,
                20.0,
                {}}})
