// One-dimensional quadrature.
#pragma once

#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace difusa {

/// Nodes (ascending) and weights on [0,1].
struct QuadratureRule {
    std::vector<double> node, weight;
    std::size_t size() const { return node.size(); }
};

/// The n roots of the Legendre polynomial P_n by Newton's method; exact for polynomials of degree 2n-1. n >= 1.
QuadratureRule gauss_legendre(std::size_t n);

/// Weights of the barycentric formula of polynomial interpolation at the nodes of gauss_legendre(n), up to a common
/// factor: (-1)^j sqrt(x_j (1 - x_j) w_j) (H. Wang and S. Xiang, "On the convergence rates of Legendre approximation",
/// Math. Comp. 81, 2012).
std::vector<double> barycentric_weights(const QuadratureRule& rule);

/// Gauss-Legendre rule on [from, to] in the variable t of x = from + (to - from) sin²(pi t / 2): half-integer powers of
/// the distance from either end are smooth in t. Calls `act(x, weight)` for each node.
template <class Act> void for_each_node(const QuadratureRule& rule, double from, double to, const Act& act) {
    for (std::size_t k = 0; k < rule.size(); ++k) {
        const double angle = 0.5 * std::numbers::pi * rule.node[k], sine = std::sin(angle), cosine = std::cos(angle);
        act(from * cosine * cosine + to * sine * sine, rule.weight[k] * (to - from) * std::numbers::pi * sine * cosine);
    }
}

} // namespace difusa
