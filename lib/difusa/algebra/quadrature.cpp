#include <difusa/algebra/quadrature.h>

namespace difusa {

QuadratureRule gauss_legendre(std::size_t n) {
    QuadratureRule rule;
    rule.node.resize(n);
    rule.weight.resize(n);
    const auto count = static_cast<double>(n);
    for (std::size_t i = 0; i < n; ++i) {
        double x = std::cos(std::numbers::pi * (static_cast<double>(n - i) - 0.25) / (count + 0.5)), slope = 0.0;
        for (int step = 0; step < 8; ++step) {
            double previous = 1.0, P = x; // P_0, P_1
            for (std::size_t k = 2; k <= n; ++k) {
                const auto degree = static_cast<double>(k);
                const double next = ((2.0 * degree - 1.0) * x * P - (degree - 1.0) * previous) / degree;
                previous = P;
                P = next;
            }
            slope = count * (x * P - previous) / (x * x - 1.0);
            x -= P / slope;
        }
        rule.node[i] = 0.5 * (1.0 + x);
        rule.weight[i] = 1.0 / ((1.0 - x * x) * slope * slope);
    }
    return rule;
}

std::vector<double> barycentric_weights(const QuadratureRule& rule) {
    std::vector<double> weights(rule.size());
    for (std::size_t j = 0; j < rule.size(); ++j) {
        const double size = std::sqrt(rule.node[j] * (1.0 - rule.node[j]) * rule.weight[j]);
        weights[j] = j % 2 == 0 ? size : -size;
    }
    return weights;
}

} // namespace difusa
