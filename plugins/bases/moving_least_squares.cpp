// Basis `moving-least-squares`: the value at x of the linear function on the tangent plane at x that best fits the
// surrounding sites. With the bells of `normalized-radial` as weights,
//     w_i(x) = K(|x - p_i| / R_i) max(0, n_x·n_i),   R_i = width r_i,   K(t) = 2t³ - 3t² + 1 on [0,1],
// and the sites projected onto the tangent plane, d_i (2-vectors from x), the fit is (Lancaster and Salkauskas 1981)
//     phi_i(x) = w_i p(0)ᵀ M⁻¹ p(d_i),   p(d) = (1, d),   M = sum_j w_j p(d_j) p(d_j)ᵀ.
// Equivalently, with v_i = w_i / sum_j w_j, the mean m = sum_i v_i d_i and the covariance C = sum_i v_i (d_i - m)(d_i -
// m)ᵀ:
//     phi_i(x) = v_i (1 - gᵀ(d_i - m)),   g = C⁻¹ m.
// These are the weights of `normalized-radial`, corrected by a slope. They sum to 1 for any g; with this one sum_i
// phi_i d_i = 0, so functions linear on a plane are reproduced up to its border, and errors are of second order.
// Negative weights occur: not a partition of unity.
//
// Where sites are few, collinear, or all on one side of x, C is nearly singular or m is far away, and g is bounded:
//   - an eigenvalue of C below `least` H², H² = sum_i v_i R_i², is raised to it in C⁻¹: no slope across a site line;
//   - g is shortened so that δ = sqrt(gᵀ C g) <= `steepest`.
// Both are continuous in w and d. Since sum_i v_i |gᵀ(d_i - m)| <= δ (Cauchy-Schwarz), always
//     sum_i |phi_i(x)| <= 1 + steepest = 5,
// and linear functions are reproduced wherever neither bound is active. With one site phi = 1.
#include <difusa/discretisation/point_basis.h>
#include <difusa/plugin/plugin.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace {

using difusa::Vec3;

/// Smallest eigenvalue of the covariance, relative to H²; a full disc of sites has 0.12, half of it 0.04.
constexpr double least = 0.004;
/// Largest distance from x to the mean of the sites in standard deviations; it is 1.4 at the border of a half-plane, 2
/// at the tip of a right angle.
constexpr double steepest = 4.0;

/// A unit vector perpendicular to the unit vector n.
Vec3 perpendicular_to(const Vec3& n) {
    const bool along_x = std::abs(n[0]) > std::abs(n[2]);
    return (along_x ? Vec3(-n[1], n[0], 0.0) : Vec3(0.0, -n[2], n[1])).normalized();
}

class MovingLeastSquares final : public difusa::PointBasis {
  public:
    explicit MovingLeastSquares(const difusa::Parameters& parameters) : width_(parameters.real("width")) {}

    bool partition_of_unity() const override { return false; }
    bool sums_to_one() const override { return true; }
    bool coefficients_are_values() const override { return true; }

  protected:
    void prepare(const difusa::SiteSet& sites) override {
        position_.reserve(sites.size());
        for (const difusa::SurfacePoint& site : sites.points) {
            position_.push_back(site.position);
        }
    }

    double support(double r) const override { return width_ * r; }

    void weigh(const difusa::SurfacePoint& x, const difusa::Neighbourhood& near,
               std::span<double> weight) const override {
        const Vec3 s = perpendicular_to(x.normal), t = x.normal.cross(s);
        double sum = 0.0, m_s = 0.0, m_t = 0.0, C_ss = 0.0, C_st = 0.0, C_tt = 0.0, H_squared = 0.0;
        for (std::size_t i = 0; i < weight.size(); ++i) {
            const double R = width_ * near.radius[i], q = near.distance[i] / R;
            const double w = (1.0 + q * q * (2.0 * q - 3.0)) * near.cosine[i];
            const Vec3 away = position_[near.site[i]] - x.position;
            const double d_s = s.dot(away), d_t = t.dot(away);
            weight[i] = w;
            sum += w;
            m_s += w * d_s;
            m_t += w * d_t;
            C_ss += w * d_s * d_s;
            C_st += w * d_s * d_t;
            C_tt += w * d_t * d_t;
            H_squared += w * R * R;
        }
        if (!(sum > 0.0)) {
            return;
        }
        m_s /= sum;
        m_t /= sum;
        C_ss = C_ss / sum - m_s * m_s;
        C_st = C_st / sum - m_s * m_t;
        C_tt = C_tt / sum - m_t * m_t;

        // Principal axes of C: eigenvalues middle ± half, the larger along (cos, sin).
        const double middle = 0.5 * (C_ss + C_tt), difference = 0.5 * (C_ss - C_tt);
        const double half = std::hypot(difference, C_st), angle = 0.5 * std::atan2(C_st, difference);
        const double cos = std::cos(angle), sin = std::sin(angle);
        const double along = cos * m_s + sin * m_t, across = cos * m_t - sin * m_s;
        const double floor = least * H_squared / sum;
        const double c_along = std::max(middle + half, 0.0), c_across = std::max(middle - half, 0.0);
        double g_along = along / std::max(c_along, floor), g_across = across / std::max(c_across, floor);
        const double delta = std::sqrt(g_along * g_along * c_along + g_across * g_across * c_across);
        if (delta > steepest) {
            g_along *= steepest / delta;
            g_across *= steepest / delta;
        }
        const double g_s = cos * g_along - sin * g_across, g_t = sin * g_along + cos * g_across;

        const Vec3 g = g_s * s + g_t * t;
        const double middle_of_fit = 1.0 + g_s * m_s + g_t * m_t;
        for (std::size_t i = 0; i < weight.size(); ++i) {
            weight[i] *= middle_of_fit - g.dot(position_[near.site[i]] - x.position);
        }
    }

  private:
    double width_;
    std::vector<Vec3> position_; ///< #S
};

} // namespace

DIFUSA_PLUGIN(basis, "moving-least-squares", MovingLeastSquares,
              "Linear fit in the tangent plane: second order, but weights may be negative.",
              {{"width",
                difusa::ParameterSpec::Type::real,
                "1",
                "support radius as a multiple of the site's radius",
                0.05,
                20.0,
                {}}})
