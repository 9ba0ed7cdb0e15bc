#include <difusa/study/references/opening.h>

#include <difusa/algebra/quadrature.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace difusa {

namespace {

/// The integral over parts of an opening.
class OpeningQuadrature {
  public:
    OpeningQuadrature(const Opening& opening, const Vec3& x, const Vec3& n, const RadianceFrom& radiance)
        : opening_(opening), x_(x), n_(n), area_(opening.u.cross(opening.v)), radiance_(radiance) {}

    double all() {
        const double whole = over(0.0, 0.0, 1.0);
        allowed_ = 1e-8 * std::abs(whole);
        return refined(0.0, 0.0, 1.0, whole, 12);
    }

  private:
    /// Over the square [s, s + side] x [t, t + side].
    double over(double s, double t, double side) const {
        double sum = 0.0;
        for (std::size_t i = 0; i < rule_.size(); ++i) {
            for (std::size_t j = 0; j < rule_.size(); ++j) {
                const Vec3 way =
                    opening_.a + (s + side * rule_.node[i]) * opening_.u + (t + side * rule_.node[j]) * opening_.v - x_;
                const double squared = way.squaredNorm();
                const Vec3 towards = way / std::sqrt(squared);
                const double cosine = n_.dot(towards);
                if (cosine > 0.0) {
                    sum += rule_.weight[i] * rule_.weight[j] * radiance_(towards) * cosine *
                           std::abs(towards.dot(area_)) / squared;
                }
            }
        }
        return sum * side * side;
    }

    double refined(double s, double t, double side, double whole, int depth) const {
        const double half = 0.5 * side;
        const std::array<std::array<double, 2>, 4> corners{
            {{s, t}, {s + half, t}, {s, t + half}, {s + half, t + half}}};
        std::array<double, 4> parts{};
        double sum = 0.0;
        for (std::size_t k = 0; k < 4; ++k) {
            sum += parts[k] = over(corners[k][0], corners[k][1], half);
        }
        if (depth == 0 || std::abs(sum - whole) <= allowed_) {
            return sum;
        }
        sum = 0.0;
        for (std::size_t k = 0; k < 4; ++k) {
            sum += refined(corners[k][0], corners[k][1], half, parts[k], depth - 1);
        }
        return sum;
    }

    const Opening& opening_;
    const Vec3 x_, n_, area_;
    const RadianceFrom& radiance_;
    const QuadratureRule rule_ = gauss_legendre(10);
    double allowed_ = 0.0;
};

} // namespace

double irradiance_through(const Opening& opening, const Vec3& x, const Vec3& n, const RadianceFrom& radiance) {
    return OpeningQuadrature(opening, x, n, radiance).all();
}

double vertical_irradiance(const Vec3& n, const RadianceFrom& radiance) {
    const QuadratureRule rule = gauss_legendre(96);
    const Vec3 side = Vec3::UnitZ().cross(n);
    double sum = 0.0;
    for (std::size_t i = 0; i < rule.size(); ++i) {
        const double elevation = 0.5 * std::numbers::pi * rule.node[i], level = std::cos(elevation);
        for (std::size_t j = 0; j < rule.size(); ++j) {
            const double azimuth = std::numbers::pi * (rule.node[j] - 0.5);
            const Vec3 towards =
                level * (std::cos(azimuth) * n + std::sin(azimuth) * side) + std::sin(elevation) * Vec3::UnitZ();
            sum += rule.weight[i] * rule.weight[j] * radiance(towards) * level * level * std::cos(azimuth);
        }
    }
    return 0.5 * std::numbers::pi * std::numbers::pi * sum;
}

} // namespace difusa
