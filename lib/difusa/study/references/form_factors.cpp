#include <difusa/study/references/form_factors.h>

#include <difusa/algebra/quadrature.h>
#include <difusa/core/error.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace difusa {

namespace {

using std::numbers::pi;

void require_positive(std::initializer_list<std::pair<const char*, double>> lengths) {
    for (const auto& [name, length] : lengths) {
        if (!(length > 0.0 && std::isfinite(length))) {
            throw UsageError("form factor: the " + std::string(name) + " must be positive and finite, not " +
                             std::to_string(length));
        }
    }
}

void require_not_negative(const char* name, double length) {
    if (!(length >= 0.0 && std::isfinite(length))) {
        throw UsageError("form factor: the " + std::string(name) + " must not be negative, not " +
                         std::to_string(length));
    }
}

void require_rectangle(const Rectangle& r) {
    if (!(std::isfinite(r.x0) && std::isfinite(r.y0))) {
        throw UsageError("form factor: a rectangle's corners must be finite");
    }
    require_positive({{"width of a rectangle", r.x1 - r.x0}, {"height of a rectangle", r.y1 - r.y0}});
}

/// Sum of g(x of `from`, x of `to`, y of `from` - y of `to`) over the corners, the upper one of each interval counted
/// as positive.
template <class G> double alternating(const Rectangle& from, const Rectangle& to, const G& g) {
    double sum = 0.0;
    for (int signs = 0; signs < 16; ++signs) {
        const bool i = (signs & 1) != 0, j = (signs & 2) != 0, k = (signs & 4) != 0, l = (signs & 8) != 0;
        const double value = g(i ? from.x1 : from.x0, j ? to.x1 : to.x0, (k ? from.y1 : from.y0) - (l ? to.y1 : to.y0));
        sum += (i != j) != (k != l) ? -value : value;
    }
    return sum;
}

/// v √q atan(v/√q), also for q = 0.
double arc(double v, double q) {
    const double root = std::sqrt(q);
    return v * root * std::atan2(v, root);
}

/// Split at the points inside, then into parts of at most `longest`.
std::vector<double> cut(double from, double to, std::vector<double> places, double longest) {
    places.push_back(to);
    std::sort(places.begin(), places.end());
    std::vector<double> ends{from};
    for (const double place : places) {
        const double start = ends.back(), length = place - start;
        if (place <= start || place > to) {
            continue;
        }
        const double parts = std::ceil(length / longest);
        for (double k = 1.0; k < parts; k += 1.0) {
            ends.push_back(start + length * k / parts);
        }
        ends.push_back(place);
    }
    return ends;
}

} // namespace

double parallel_rectangles(const Rectangle& from, const Rectangle& to, double distance) {
    require_rectangle(from);
    require_rectangle(to);
    require_positive({{"distance", distance}});
    // In units of the distance.
    const double sum = alternating(from, to, [&](double x, double x_to, double y) {
        const double u = (x - x_to) / distance, v = y / distance;
        return arc(v, u * u + 1.0) + arc(u, v * v + 1.0) - 0.5 * std::log1p(u * u + v * v);
    });
    return sum / (2.0 * pi) * distance * distance / from.area();
}

double opposite_rectangles(double a, double b, double distance) {
    const Rectangle r{0.0, a, 0.0, b};
    return parallel_rectangles(r, r, distance);
}

double perpendicular_rectangles(const Rectangle& from, const Rectangle& to) {
    require_rectangle(from);
    require_rectangle(to);
    require_not_negative("x of a rectangle at right angles", from.x0);
    require_not_negative("z of a rectangle at right angles", to.x0);
    const double unit = std::max({from.x1, to.x1, std::abs(from.y1 - to.y0), std::abs(to.y1 - from.y0)});
    const double sum = alternating(from, to, [&](double x, double z, double y) {
        const double q = (x * x + z * z) / (unit * unit), v = y / unit, square = q + v * v;
        // (q - v²) ln(q + v²) vanishes with q + v².
        return 2.0 * arc(v, q) - (square > 0.0 ? 0.5 * (q - v * v) * std::log(square) : 0.0);
    });
    return sum / (4.0 * pi) * unit * unit / from.area();
}

double rectangles_with_common_edge(double edge, double depth, double height) {
    return perpendicular_rectangles({0.0, depth, 0.0, edge}, {0.0, height, 0.0, edge});
}

double coaxial_discs(double r1, double r2, double distance) {
    require_positive({{"radius of a disc", r1}, {"radius of a disc", r2}, {"distance", distance}});
    const double q = r2 / r1, h = distance / r1;
    const double S = 1.0 + q * q + h * h; // S² - 4q² = ((1-q)² + h²) ((1+q)² + h²)
    return 2.0 * q * q / (S + std::hypot(1.0 - q, h) * std::hypot(1.0 + q, h));
}

double element_to_disc(double r, double h, double a) {
    require_positive({{"radius of a disc", r}, {"distance", h}});
    require_not_negative("distance from the disc's axis", a);
    const double A = a / r, H = h / r, m = A * A + H * H - 1.0, root = std::hypot(A - 1.0, H) * std::hypot(A + 1.0, H);
    // root² - m² = 4 H²
    return m > 0.0 ? 2.0 * H * H / (root * (root + m)) : 0.5 * (1.0 - m / root);
}

double element_to_rectangle(const Rectangle& rectangle, double h) {
    require_rectangle(rectangle);
    require_positive({{"distance", h}});
    const auto f = [&](double x, double y) {
        const double X = x / h, Y = y / h, A = std::hypot(1.0, X), B = std::hypot(1.0, Y);
        return X / A * std::atan(Y / A) + Y / B * std::atan(X / B);
    };
    const auto& [x0, x1, y0, y1] = rectangle;
    return (f(x1, y1) - f(x0, y1) - f(x1, y0) + f(x0, y0)) / (2.0 * pi);
}

double element_to_ball(double r, double h, double u) {
    require_positive({{"radius of a ball", r}, {"height of a ball", h}});
    require_not_negative("distance from the ball's axis", u);
    if (h < r) {
        throw UsageError("form factor: the ball must be entirely above the horizon; its centre is at " +
                         std::to_string(h) + ", its radius " + std::to_string(r));
    }
    const double distance = std::hypot(h, u);
    return r / distance * (r / distance) * (h / distance);
}

double ball_to_coaxial_disc(double r, double h) {
    require_positive({{"radius of a disc", r}, {"distance", h}});
    const double slant = std::hypot(r, h);
    return 0.5 * (r / slant) * (r / (slant + h));
}

double cylinder_to_itself(double r, double length) {
    require_positive({{"radius of a cylinder", r}, {"length of a cylinder", length}});
    const double H = 0.5 * length / r;
    return 2.0 * H / (1.0 + H + std::hypot(1.0, H));
}

double cylinder_element_to_section(double r, double t) {
    require_positive({{"radius of a cylinder", r}});
    require_not_negative("distance along a cylinder", t);
    const double X = 0.5 * t / r, root = std::hypot(1.0, X); // (X² + 1/2)² - X² (X² + 1) = 1/4
    return 0.25 / (root * (X * X + 0.5 + X * root));
}

double crossed_strings(const Eigen::Vector2d& a0, const Eigen::Vector2d& a1, const Eigen::Vector2d& b0,
                       const Eigen::Vector2d& b1) {
    require_positive({{"length of a segment", (a1 - a0).norm()}, {"length of a segment", (b1 - b0).norm()}});
    const auto apart = [](const Eigen::Vector2d& p, const Eigen::Vector2d& q, const Eigen::Vector2d& c,
                          const Eigen::Vector2d& d) {
        const Eigen::Vector2d along = q - p, to_c = c - p, to_d = d - p;
        return (along.x() * to_c.y() - along.y() * to_c.x()) * (along.x() * to_d.y() - along.y() * to_d.x()) >= 0.0;
    };
    if (!apart(a0, a1, b0, b1) || !apart(b0, b1, a0, a1)) {
        throw UsageError("crossed strings: the line of one segment passes through the other, which is then seen from "
                         "both sides; split it there");
    }
    // Of the two ways to join the ends, the crossed one is longer.
    const double straight = (b0 - a0).norm() + (b1 - a1).norm(), other = (b1 - a0).norm() + (b0 - a1).norm();
    return 0.5 * std::abs(straight - other) / (a1 - a0).norm();
}

ShelfFormFactors shelf(double a, double b) {
    require_positive({{"depth of a shelf", a}, {"height of a shelf", b}});
    const double slant = std::hypot(a, b);
    return {b / (a + b + slant), a / (slant + b), a / (a + b + slant)};
}

double blocked_rectangles(const Rectangle& from, const Rectangle& to, double distance, const Rectangle& blocker,
                          double height) {
    const double free = parallel_rectangles(from, to, distance);
    require_rectangle(blocker);
    require_positive({{"height of the blocker", height}, {"distance above the blocker", distance - height}});
    const double m = distance / height; // the shadow of X from x is m X - (m - 1) x
    const auto pieces = [&](double from0, double from1, std::array<double, 2> to_ends, std::array<double, 2> ends) {
        std::vector<double> places;
        for (const double X : ends) {
            for (const double T : to_ends) {
                places.push_back((m * X - T) / (m - 1.0));
            }
        }
        // Poles of the integrand are at distance `distance` from the real axis, for the shadow's edges at that over m.
        return cut(from0, from1, places, distance / std::max(1.0, m));
    };
    const std::vector<double> in_x = pieces(from.x0, from.x1, {to.x0, to.x1}, {blocker.x0, blocker.x1}),
                              in_y = pieces(from.y0, from.y1, {to.y0, to.y1}, {blocker.y0, blocker.y1});
    const QuadratureRule rule = gauss_legendre(16);
    double hidden = 0.0;
    for (std::size_t a = 0; a + 1 < in_x.size(); ++a) {
        for (std::size_t b = 0; b + 1 < in_y.size(); ++b) {
            const double width = in_x[a + 1] - in_x[a], depth = in_y[b + 1] - in_y[b];
            for (std::size_t i = 0; i < rule.size(); ++i) {
                for (std::size_t j = 0; j < rule.size(); ++j) {
                    const double x = in_x[a] + rule.node[i] * width, y = in_y[b] + rule.node[j] * depth;
                    const Rectangle shadow{std::max(to.x0, m * blocker.x0 - (m - 1.0) * x) - x,
                                           std::min(to.x1, m * blocker.x1 - (m - 1.0) * x) - x,
                                           std::max(to.y0, m * blocker.y0 - (m - 1.0) * y) - y,
                                           std::min(to.y1, m * blocker.y1 - (m - 1.0) * y) - y};
                    if (shadow.x0 < shadow.x1 && shadow.y0 < shadow.y1) {
                        hidden +=
                            rule.weight[i] * width * rule.weight[j] * depth * element_to_rectangle(shadow, distance);
                    }
                }
            }
        }
    }
    return std::max(0.0, free - hidden / from.area());
}

} // namespace difusa
