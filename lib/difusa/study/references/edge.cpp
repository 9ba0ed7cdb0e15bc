#include <difusa/study/references/edge.h>

#include <difusa/study/references/check_parameter.h>

#include <cmath>
#include <numbers>

namespace difusa {

double edge_symbol(double gamma) {
    check_parameter("light at an edge", gamma > -2.0 && gamma < 1.0, "the exponent must be between -2 and 1", gamma);
    // The beta function in terms of the gamma function, whose value at 3/2 is the root of pi, halved.
    return std::tgamma(1.0 + 0.5 * gamma) * std::tgamma(0.5 - 0.5 * gamma) * 0.5 * std::numbers::inv_sqrtpi;
}

double edge_exponent(double rho) {
    check_parameter("light at an edge", rho > 0.0 && rho <= 1.0, "the reflectance must be in (0,1]", rho);
    double low = 0.0, high = 1.0; // rho K is below 1 at low, and above it at high
    for (double middle = 0.5; middle > low && middle < high; middle = 0.5 * (low + high)) {
        (rho * edge_symbol(middle) < 1.0 ? low : high) = middle;
    }
    return low;
}

} // namespace difusa
