#include <difusa/form_factors/unblocked.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace difusa {

namespace {

/// Rules are used from this multiple of the sum of the radii on.
constexpr double least_distance = 2.5;

/// The largest errors among thousands of random pairs of triangles were 0.55, 0.044 and 0.023 in these units, at all
/// distances from `least_distance` on.
struct RuleError {
    std::size_t points;
    int degree;
    double factor;
};
constexpr std::array<RuleError, 3> rule_errors{{{1, 1, 2.2}, {3, 2, 0.2}, {7, 5, 0.1}}};

double power(double q, int n) {
    double product = 1.0;
    for (int k = 0; k < n; ++k) {
        product *= q;
    }
    return product;
}

/// The points of the rule on each triangle of a fan, with weights that sum to the area.
struct WeightedPoints {
    std::array<Vec3, 7 * (FlatPolygon::capacity - 2)> point; // NOLINT: the first `count` are filled
    std::array<double, 7 * (FlatPolygon::capacity - 2)> weight;
    std::size_t count = 0;

    WeightedPoints(const PolygonEnd& P, std::span<const TrianglePoint> rule) { // NOLINT: as above
        const FlatPolygon& corners = P.polygon;
        if (rule.size() == 1) {
            point[0] = P.centre;
            weight[0] = P.area;
            count = 1;
            return;
        }
        for (std::size_t k = 2; k < corners.size(); ++k) {
            const Vec3 a = corners[k - 1] - corners[0], b = corners[k] - corners[0];
            const double area = 0.5 * a.cross(b).dot(P.plane.normal);
            for (const TrianglePoint& p : rule) {
                point[count] = corners[0] + p.u * a + p.v * b;
                weight[count++] = p.weight * area;
            }
        }
    }
};

double by_points(const PolygonEnd& P, const PolygonEnd& Q, std::size_t points) {
    const std::span<const TrianglePoint> rule = triangle_rule(points);
    const WeightedPoints p(P, rule), q(Q, rule);
    double sum = 0.0;
    for (std::size_t i = 0; i < p.count; ++i) {
        double inner = 0.0;
        for (std::size_t j = 0; j < q.count; ++j) {
            const Vec3 way = q.point[j] - p.point[i];
            const double square = way.squaredNorm();
            inner += q.weight[j] * P.plane.normal.dot(way) * -Q.plane.normal.dot(way) / (square * square);
        }
        sum += p.weight[i] * inner;
    }
    return std::max(0.0, sum * std::numbers::inv_pi);
}

} // namespace

PolygonEnd::PolygonEnd(const FlatPolygon& corners, const Vec3& normal) : polygon(corners) {
    Vec3 moment = Vec3::Zero();
    for (std::size_t k = 2; k < corners.size(); ++k) {
        const Vec3 a = corners[k - 1] - corners[0], b = corners[k] - corners[0];
        const double part = 0.5 * a.cross(b).dot(normal);
        area += part;
        moment += part / 3.0 * (a + b);
    }
    centre = area > 0.0 && corners.size() >= 3 ? Vec3(corners[0] + moment / area)
             : corners.size() > 0              ? corners.mean_corner()
                                               : Vec3(Vec3::Zero());
    plane = {normal, normal.dot(centre)};
    for (const Vec3& p : corners.corners()) {
        radius = std::max(radius, (p - centre).norm());
    }
}

std::span<const TrianglePoint> triangle_rule(std::size_t points) {
    static constexpr std::array<TrianglePoint, 1> one{{{1.0 / 3.0, 1.0 / 3.0, 1.0}}};
    static constexpr std::array<TrianglePoint, 3> three{
        {{1.0 / 6.0, 1.0 / 6.0, 1.0 / 3.0}, {2.0 / 3.0, 1.0 / 6.0, 1.0 / 3.0}, {1.0 / 6.0, 2.0 / 3.0, 1.0 / 3.0}}};
    // a = (6 ± √15)/21, weights (155 ± √15)/1200.
    constexpr double root = 3.872983346207417;
    constexpr double a = (6.0 - root) / 21.0, b = (6.0 + root) / 21.0;
    constexpr double weight_a = (155.0 - root) / 1200.0, weight_b = (155.0 + root) / 1200.0;
    static constexpr std::array<TrianglePoint, 7> seven{{{1.0 / 3.0, 1.0 / 3.0, 0.225},
                                                         {a, a, weight_a},
                                                         {1.0 - 2.0 * a, a, weight_a},
                                                         {a, 1.0 - 2.0 * a, weight_a},
                                                         {b, b, weight_b},
                                                         {1.0 - 2.0 * b, b, weight_b},
                                                         {b, 1.0 - 2.0 * b, weight_b}}};
    if (points == 1) {
        return one;
    }
    return points == 3 ? std::span<const TrianglePoint>(three) : std::span<const TrianglePoint>(seven);
}

Estimate unblocked_exchange(const PolygonEnd& P, const PolygonEnd& Q, double tolerance) {
    if (P.polygon.empty() || Q.polygon.empty() || !(P.area > 0.0 && Q.area > 0.0)) {
        return {};
    }
    const double R = std::max(P.radius, Q.radius), D = (Q.centre - P.centre).norm();
    if (D > least_distance * (P.radius + Q.radius)) {
        const double q = R / D, scale = P.area * Q.area / (std::numbers::pi * D * D);
        for (const RuleError& rule : rule_errors) {
            const double error = rule.factor * scale * power(q, rule.degree + 1);
            if (error <= tolerance) {
                return {by_points(P, Q, rule.points), error};
            }
        }
    }
    // The contour's error is relative to the product of the perimeters, each at most 2 pi times a radius.
    const double perimeters = 2.0 * std::numbers::pi * P.radius * Q.radius;
    return contour_exchange(P.polygon, Q.polygon, std::clamp(tolerance / perimeters, 1e-14, 1e-6));
}

} // namespace difusa
