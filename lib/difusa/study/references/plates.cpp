#include <difusa/study/references/plates.h>

#include <difusa/study/references/check_parameter.h>
#include <difusa/study/references/form_factors.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace difusa {

Plates::Plates(const PlatesParameters& parameters) : parameters_(parameters) {
    const auto& [E1, E2, rho1, rho2, gap] = parameters;
    for (const double E : {E1, E2}) {
        check_parameter("parallel plates", E >= 0.0 && std::isfinite(E), "the emission must be finite and not negative",
                        E);
    }
    for (const double rho : {rho1, rho2}) {
        check_parameter("parallel plates", rho >= 0.0 && rho <= 1.0, "the reflectance must be in [0,1]", rho);
    }
    check_parameter("parallel plates", rho1 * rho2 < 1.0, "the product of the reflectances must be less than 1",
                    rho1 * rho2);
    check_parameter("parallel plates", gap > 0.0 && std::isfinite(gap), "the gap must be positive", gap);
}

double Plates::B(int plate) const {
    const auto& [E1, E2, rho1, rho2, gap] = parameters_;
    return (plate == 1 ? E1 + rho1 * E2 : E2 + rho2 * E1) / (1.0 - rho1 * rho2);
}

ReferenceLight Plates::at(const Vec3& /*x*/, const Vec3& n) const {
    const auto& [E1, E2, rho1, rho2, gap] = parameters_;
    return n.z() > 0.0 ? ReferenceLight{E1, rho1, B(2), E2} : ReferenceLight{E2, rho2, B(1), E1};
}

Plates::Missing Plates::missing_in_the_middle(int plate, double side) const {
    check_parameter("parallel plates", plate == 1 || plate == 2, "plates are numbered 1 and 2", plate);
    check_parameter("parallel plates", side > 0.0 && std::isfinite(side), "the side must be positive", side);
    const double own = plate == 1 ? parameters_.rho1 : parameters_.rho2,
                 other = plate == 1 ? parameters_.rho2 : parameters_.rho1;
    const double half = 0.5 * side / parameters_.gap; // gap 1 from here on
    const double outside = 1.0 - element_to_rectangle({-half, half, -half, half}, 1.0);
    double sum = 0.0, w = own;
    for (double k = 1.0;; k += 1.0) {
        const double next = w * (std::fmod(k, 2.0) == 1.0 ? other : own), t = half / k, q = k / (1.0 + t * t);
        if (q >= 1.0) {
            sum += w; // from here on the sum of w_k - w_{k+1}
            break;
        }
        sum += (w - next) * q;
        if (next == 0.0) {
            break;
        }
        w = next;
    }
    return {own * B(3 - plate) * outside, std::max(B(1), B(2)) * sum};
}

} // namespace difusa
