#include <difusa/form_factors/contour.h>

#include <difusa/algebra/quadrature.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace difusa {

namespace {

constexpr std::size_t most_contour_nodes = 12;

/// Intervals shorter than this share of an edge are not split further: what is left of a logarithm is below rounding.
constexpr double shortest_interval = 0x1p-46;

/// gauss_legendre(n) for n up to `most_contour_nodes`, by n.
const std::array<QuadratureRule, most_contour_nodes + 1>& contour_rules() {
    static const auto rules = [] {
        std::array<QuadratureRule, most_contour_nodes + 1> made;
        for (std::size_t n = 1; n <= most_contour_nodes; ++n) {
            made[n] = gauss_legendre(n);
        }
        return made;
    }();
    return rules;
}

struct ContourEdge {
    Vec3 from, to, direction; ///< direction: unit
    double length;
};

/// ∫ ln|y - p| dy along an edge. With t along the edge from the foot of p, and d the distance of p from its line, the
/// antiderivative is t ln √(t² + d²) - t + d atan(t/d).
double log_distance(const Vec3& p, const ContourEdge& edge) {
    const Vec3 first = edge.from - p, last = edge.to - p;
    const double t0 = first.dot(edge.direction), t1 = last.dot(edge.direction);
    const double r0 = first.squaredNorm(), r1 = last.squaredNorm();
    double sum = -edge.length;
    if (r1 > 0.0) {
        sum += 0.5 * t1 * std::log(r1);
    }
    if (r0 > 0.0) {
        sum -= 0.5 * t0 * std::log(r0);
    }
    // The angle under which p sees the edge: tangent d L / (d² + t0 t1).
    const double d = first.cross(edge.direction).norm();
    return d > 0.0 ? sum + d * std::atan2(d * edge.length, first.dot(last)) : sum;
}

/// How far from the place p on the line of an edge the inner integral over another edge is analytic, as a function of a
/// complex coordinate along that line. The squared distance from an end point y has zeros at |p - y|, that from the
/// other line at its distance divided by the sine of the angle between the lines. The latter does not count where the
/// lines are the same, but for rounding, up to the distance `half` from p: the term of the integral that has the
/// distance as a factor is rounding, too.
double analytic_radius(const Vec3& p, const ContourEdge& other, double sine, double half) {
    constexpr double rounding = 0x1p-46;
    const Vec3 first = other.from - p;
    const double from_start = first.squaredNorm();
    const double ends = std::sqrt(std::min(from_start, (other.to - p).squaredNorm()));
    const double line = first.cross(other.direction).norm();
    const bool same_line = line + sine * half <= rounding * std::max(std::sqrt(from_start), other.length);
    return !same_line && line < sine * ends ? line / sine : ends;
}

/// ∫∫ ln|x - y| dx dy over two edges with a common end point, u and v being the other ends relative to it. With both
/// edges scaled by R, the integral is R² (F + ln R |u| |v|); its derivative at R = 1 is that over the two moving ends.
/// Hence 2 F + |u| |v| = |u| ∫ ln|u - y| dy + |v| ∫ ln|x - v| dx.
double log_distance_common_end(const ContourEdge& u, const ContourEdge& v) {
    return 0.5 * (u.length * log_distance(u.to, v) + v.length * log_distance(v.to, u) - u.length * v.length);
}

/// ∫∫ ln|x - y| dx dy over two edges in any position, over [from, to] of the first one's length; `sine`: of the angle
/// between them. n nodes give an error of rho^-2n, rho = D/h + √(1 + (D/h)²) for an interval of half length h whose
/// inner integral is analytic up to the distance D from its middle.
double log_distance_over(const ContourEdge& u, const ContourEdge& v, double sine, double from, double to,
                         double log_accuracy) {
    const double half = 0.5 * (to - from), middle = 0.5 * (from + to);
    const double radius = analytic_radius(u.from + middle * u.direction, v, sine, half);
    const double wanted = radius > 0.5 * half ? -0.5 * log_accuracy / std::asinh(radius / half) : 1e9;
    if (wanted > static_cast<double>(most_contour_nodes) && half > shortest_interval * u.length) {
        return log_distance_over(u, v, sine, from, middle, log_accuracy) +
               log_distance_over(u, v, sine, middle, to, log_accuracy);
    }
    const auto n = static_cast<std::size_t>(std::clamp(std::ceil(wanted), 2.0, double{most_contour_nodes}));
    const QuadratureRule& rule = contour_rules()[n];
    double sum = 0.0;
    for (std::size_t k = 0; k < n; ++k) {
        sum += rule.weight[k] * log_distance(u.from + (from + rule.node[k] * (to - from)) * u.direction, v);
    }
    return sum * (to - from);
}

ContourEdge reversed(const ContourEdge& edge) {
    return {edge.to, edge.from, -edge.direction, edge.length};
}

double log_distance_of(const ContourEdge& u, const ContourEdge& v, double log_accuracy) {
    if (u.from == v.from) {
        return log_distance_common_end(u, v);
    }
    if (u.from == v.to) {
        return log_distance_common_end(u, reversed(v));
    }
    if (u.to == v.from) {
        return log_distance_common_end(reversed(u), v);
    }
    if (u.to == v.to) {
        return log_distance_common_end(reversed(u), reversed(v));
    }
    const double sine = u.direction.cross(v.direction).norm();
    return u.length <= v.length ? log_distance_over(u, v, sine, 0.0, u.length, log_accuracy)
                                : log_distance_over(v, u, sine, 0.0, v.length, log_accuracy);
}

struct ContourEdges {
    std::array<ContourEdge, FlatPolygon::capacity> edge; // NOLINT: the first `count` are filled
    std::size_t count = 0;
};

/// Edges of positive length, with coordinates (p - origin) / unit.
void collect_edges(const FlatPolygon& P, const Vec3& origin, double unit, ContourEdges& edges) {
    for (std::size_t k = 0; k < P.size(); ++k) {
        const Vec3 from = (P[k] - origin) / unit, to = (P.next(k) - origin) / unit;
        const double length = (to - from).norm();
        if (length > 0.0) {
            edges.edge[edges.count++] = {from, to, (to - from) / length, length};
        }
    }
}

} // namespace

Estimate contour_exchange(const FlatPolygon& P, const FlatPolygon& Q, double accuracy) {
    if (P.empty() || Q.empty()) {
        return {};
    }
    // Any unit will do, since ∮ dx = 0: that of the distance makes the logarithms small.
    const Vec3 origin = P.mean_corner();
    double unit = (Q.mean_corner() - origin).norm();
    if (!(unit > 0.0)) {
        unit = 1.0;
    }
    ContourEdges p, q;
    collect_edges(P, origin, unit, p);
    collect_edges(Q, origin, unit, q);
    const double log_accuracy = std::log(accuracy);
    double sum = 0.0, scale = 0.0;
    for (std::size_t i = 0; i < p.count; ++i) {
        for (std::size_t j = 0; j < q.count; ++j) {
            const ContourEdge &u = p.edge[i], &v = q.edge[j];
            const double cosine = u.direction.dot(v.direction);
            if (std::abs(cosine) > 0x1p-52) {
                sum += cosine * log_distance_of(u, v, log_accuracy);
            }
            scale += u.length * v.length;
        }
    }
    const double factor = unit * unit / (2.0 * std::numbers::pi);
    return {std::max(0.0, sum * factor), scale * factor * (accuracy + 0x1p-50)};
}

} // namespace difusa
