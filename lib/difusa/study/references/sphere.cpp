#include <difusa/study/references/sphere.h>

#include <difusa/algebra/quadrature.h>
#include <difusa/core/error.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

namespace difusa {

namespace {

double checked(double E) {
    if (!(E >= 0.0 && std::isfinite(E))) {
        throw UsageError("inside of a sphere: the emission must be finite and not negative, not " + std::to_string(E));
    }
    return E;
}

} // namespace

InsideOfSphere::InsideOfSphere(double rho, std::function<double(const Vec3&)> emission, std::optional<double> mean,
                               double tolerance)
    : rho_(rho), emission_(std::move(emission)) {
    if (!(rho >= 0.0 && rho < 1.0)) {
        throw UsageError("inside of a sphere: the reflectance must be in [0,1), not " + std::to_string(rho));
    }
    if (mean) {
        mean_ = checked(*mean);
        return;
    }
    double previous = 0.0;
    for (std::size_t n = 4; n <= 1024; n *= 2) {
        const QuadratureRule rule = gauss_legendre(n);
        double largest = 0.0;
        mean_ = 0.0;
        for (std::size_t i = 0; i < n; ++i) {
            const double z = 2.0 * rule.node[i] - 1.0, radius = std::sqrt((1.0 - z) * (1.0 + z));
            for (std::size_t k = 0; k < 2 * n; ++k) {
                const double angle = std::numbers::pi * (static_cast<double>(k) + 0.5) / static_cast<double>(n);
                const double E = checked(emission_(Vec3(radius * std::cos(angle), radius * std::sin(angle), z)));
                mean_ += rule.weight[i] * E / static_cast<double>(2 * n);
                largest = std::max(largest, E);
            }
        }
        if (n > 4 && std::abs(mean_ - previous) <= tolerance * largest) {
            return;
        }
        previous = mean_;
    }
    throw NotConverged("inside of a sphere: the mean of the emission does not converge; is it smooth? Give its mean");
}

ReferenceLight InsideOfSphere::at(const Vec3& x, const Vec3& /*n*/) const {
    const double length = x.norm();
    if (!(length > 0.0)) {
        throw UsageError("inside of a sphere: the origin is not on it");
    }
    return {checked(emission_(x / length)), rho_, mean_ / (1.0 - rho_), mean_};
}

} // namespace difusa
