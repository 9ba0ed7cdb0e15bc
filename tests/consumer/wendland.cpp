// Basis `wendland`: the function of Wendland with two continuous derivatives, positive definite in space (Wendland
// 1995), over the site distance and normalised:
//     phi_i = w_i / sum_j w_j,   w_i = (1-t)^4 (4t+1),   t = ‖x,p_i‖ / (width r_i) < 1.
#include <difusa/discretisation/point_basis.h>
#include <difusa/plugin/plugin.h>

#include <cmath>

namespace {

class Wendland final : public difusa::PointBasis {
  public:
    explicit Wendland(const difusa::Parameters& parameters) : width_(parameters.real("width")) {}

    bool partition_of_unity() const override { return true; }
    bool coefficients_are_values() const override { return true; }

  protected:
    double support(double r) const override { return width_ * r; }

    void weigh(const difusa::SurfacePoint& /*x*/, const difusa::Neighbourhood& near,
               std::span<double> weight) const override {
        for (std::size_t i = 0; i < weight.size(); ++i) {
            const double t = near.distance[i] / (near.cosine[i] * width_ * near.radius[i]);
            weight[i] = t < 1.0 ? std::pow(1.0 - t, 4) * (4.0 * t + 1.0) : 0.0;
        }
    }

  private:
    double width_;
};

} // namespace

DIFUSA_PLUGIN(
    basis, "wendland", Wendland, "Wendland's C2 function, normalised.",
    {{"width", difusa::ParameterSpec::Type::real, "1", "support as a multiple of the site's radius", 0.05, 20.0, {}}})
