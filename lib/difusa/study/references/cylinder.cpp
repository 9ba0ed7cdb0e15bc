#include <difusa/study/references/cylinder.h>

#include <difusa/study/references/check_parameter.h>
#include <difusa/study/references/form_factors.h>

#include <cmath>
#include <string>

namespace difusa {

namespace {

/// Eigenvalue of K for cos(n theta).
double lambda(int n) {
    return 1.0 / (1.0 - 4.0 * n * n);
}

} // namespace

InsideOfCylinder::InsideOfCylinder(const CylinderParameters& parameters) : parameters_(parameters) {
    const auto& [radius, rho, constant, amplitude, waves] = parameters;
    check_parameter("inside of a cylinder", radius > 0.0 && std::isfinite(radius), "the radius must be positive",
                    radius);
    check_parameter("inside of a cylinder", rho >= 0.0 && rho < 1.0, "the reflectance must be in [0,1)", rho);
    check_parameter("inside of a cylinder", constant >= 0.0 && std::isfinite(constant),
                    "the constant part of the emission must not be negative", constant);
    check_parameter("inside of a cylinder", std::abs(amplitude) <= constant,
                    "the emission would be negative: its amplitude must be at most the constant", amplitude);
    check_parameter("inside of a cylinder", waves >= 1, "the number of waves must be at least 1", waves);
}

ReferenceLight InsideOfCylinder::at(const Vec3& x, const Vec3& /*n*/) const {
    check_parameter("inside of a cylinder", std::hypot(x.x(), x.y()) > 0.0,
                    "the axis is not on its surface; the distance from it must be positive", 0.0);
    const auto& [radius, rho, constant, amplitude, waves] = parameters_;
    const double wave = amplitude * std::cos(waves * std::atan2(x.y(), x.x())), l = lambda(waves);
    return {constant + wave, rho, constant / (1.0 - rho) + wave * l / (1.0 - rho * l), constant + l * wave};
}

InsideOfCylinder::Missing InsideOfCylinder::missing_in_the_middle(double length) const {
    check_parameter("inside of a cylinder", length > 0.0 && std::isfinite(length), "the length must be positive",
                    length);
    const auto& [radius, rho, constant, amplitude, waves] = parameters_;
    const double mean = constant / (1.0 - rho), wave = std::abs(amplitude) / (1.0 - rho * lambda(waves));
    double sum = 0.0, w = rho;
    for (double k = 1.0; w > 0.0; k += 1.0, w *= rho) {
        const double q = 2.0 * k * cylinder_element_to_section(radius, 0.5 * length / k);
        if (q >= 1.0) {
            sum += w; // from here on the sum of rho^k - rho^(k+1)
            break;
        }
        sum += w * (1.0 - rho) * q;
    }
    return {rho * (mean - wave) * 2.0 * cylinder_element_to_section(radius, 0.5 * length), (mean + wave) * sum};
}

} // namespace difusa
