#include <difusa/core/round_values.h>

#include <cmath>

namespace difusa {

std::vector<double> multiples_in(double low, double high, double step) {
    std::vector<double> values;
    const double slack = 1e-9 * (high - low);
    double k = std::ceil((low - slack) / step);
    while (k * step <= high + slack) {
        values.push_back(k * step + 0.0); // not -0
        if (k + 1.0 == k) {
            break; // beyond 2^53
        }
        ++k;
    }
    return values;
}

double power_of_ten_below(double value) {
    return std::pow(10.0, std::floor(std::log10(value)));
}

} // namespace difusa
