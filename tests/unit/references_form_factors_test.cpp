#include <difusa/study/references/form_factors.h>

#include <difusa/algebra/quadrature.h>
#include <difusa/core/error.h>
#include <difusa/core/random.h>
#include <difusa/core/types.h>

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

namespace difusa::references_form_factors_test {
namespace {

constexpr double pi = std::numbers::pi;

double integral(std::size_t nodes, double from, double to, const std::function<double(double)>& f) {
    const QuadratureRule rule = gauss_legendre(nodes);
    double sum = 0.0;
    for (std::size_t k = 0; k < nodes; ++k) {
        sum += rule.weight[k] * (to - from) * f(from + rule.node[k] * (to - from));
    }
    return sum;
}

/// ∫∫ kernel over both rectangles, divided by the area of the first: 14 nodes in each direction.
double by_quadrature(const Rectangle& a, const Rectangle& b,
                     const std::function<double(double, double, double, double)>& kernel) {
    const QuadratureRule rule = gauss_legendre(14);
    const auto at = [&](double from, double to, std::size_t k) { return from + rule.node[k] * (to - from); };
    double sum = 0.0;
    for (std::size_t i = 0; i < rule.size(); ++i) {
        for (std::size_t j = 0; j < rule.size(); ++j) {
            for (std::size_t k = 0; k < rule.size(); ++k) {
                for (std::size_t l = 0; l < rule.size(); ++l) {
                    sum += rule.weight[i] * rule.weight[j] * rule.weight[k] * rule.weight[l] *
                           kernel(at(a.x0, a.x1, i), at(a.y0, a.y1, j), at(b.x0, b.x1, k), at(b.y0, b.y1, l));
                }
            }
        }
    }
    return sum * b.area();
}

TEST(FormFactors, UnitSquares) {
    EXPECT_NEAR(opposite_rectangles(1.0, 1.0, 1.0), 0.199824895698387, 1e-15);
    EXPECT_NEAR(rectangles_with_common_edge(1.0, 1.0, 1.0), 0.200043776075403, 1e-15);
}

TEST(FormFactors, ParallelRectanglesByQuadrature) {
    const Rectangle a{-0.3, 0.9, 0.2, 1.0}, b{0.4, 1.1, -0.5, 0.1};
    const double h = 1.3;
    const double F = by_quadrature(a, b, [&](double x, double y, double u, double v) {
        const double square = h * h + (x - u) * (x - u) + (y - v) * (y - v);
        return h * h / (pi * square * square);
    });
    EXPECT_NEAR(parallel_rectangles(a, b, h), F, 1e-13);
    EXPECT_NEAR(a.area() * parallel_rectangles(a, b, h), b.area() * parallel_rectangles(b, a, h), 1e-15);
}

TEST(FormFactors, PerpendicularRectanglesByQuadrature) {
    const Rectangle a{0.5, 1.4, 0.2, 1.0}, b{0.6, 1.1, -0.5, 0.1};
    const double F = by_quadrature(a, b, [&](double x, double y, double z, double v) {
        const double square = x * x + z * z + (y - v) * (y - v);
        return x * z / (pi * square * square);
    });
    EXPECT_NEAR(perpendicular_rectangles(a, b), F, 1e-13);
    EXPECT_NEAR(a.area() * perpendicular_rectangles(a, b), b.area() * perpendicular_rectangles(b, a), 1e-15);
}

/// Each side of a box sees the five others and nothing else.
TEST(FormFactors, ABoxIsClosed) {
    for (const Vec3& s : {Vec3(1, 1, 1), Vec3(1, 2, 3), Vec3(0.2, 5, 1), Vec3(1e6, 2e6, 3e6), Vec3(1e-6, 3e-6, 2e-6)}) {
        const double a = s.x(), b = s.y(), c = s.z();
        EXPECT_NEAR(opposite_rectangles(a, b, c) + 2.0 * rectangles_with_common_edge(a, b, c) +
                        2.0 * rectangles_with_common_edge(b, a, c),
                    1.0, 1e-13)
            << s.transpose();
    }
}

/// Parts of a rectangle add up, also where they touch the other rectangle.
TEST(FormFactors, PartsOfARectangleAddUp) {
    const Rectangle a{0.0, 1.0, 0.0, 2.0};
    EXPECT_NEAR(perpendicular_rectangles(a, {0.0, 0.3, 0.0, 1.2}) + perpendicular_rectangles(a, {0.3, 1.5, 0.0, 1.2}) +
                    perpendicular_rectangles(a, {0.0, 1.5, 1.2, 2.0}),
                rectangles_with_common_edge(2.0, 1.0, 1.5), 1e-14);
    EXPECT_NEAR(parallel_rectangles(a, {0.0, 0.3, 0.0, 2.0}, 0.1) + parallel_rectangles(a, {0.3, 1.0, 0.0, 2.0}, 0.1),
                opposite_rectangles(1.0, 2.0, 0.1), 1e-13);
}

TEST(FormFactors, AnElementBeforeADisc) {
    const auto by_rings = [](double r, double h, double a) { // trapezoids in angle, Gauss in the radius
        return integral(40, 0.0, r, [&](double s) {
            double sum = 0.0;
            for (int k = 0; k < 64; ++k) {
                const double square = h * h + s * s + a * a - 2.0 * a * s * std::cos(2.0 * pi * k / 64.0);
                sum += h * h / (pi * square * square);
            }
            return 2.0 * pi * s * sum / 64.0;
        });
    };
    for (const double a : {0.0, 0.4, 1.0, 2.5}) {
        EXPECT_NEAR(element_to_disc(1.2, 1.0, a), by_rings(1.2, 1.0, a), 1e-13) << a;
    }
    EXPECT_NEAR(element_to_disc(3.0, 4.0), 9.0 / 25.0, 1e-15);
    // Far away r²/h², where the formula as it is usually written would be lost in rounding.
    EXPECT_NEAR(element_to_disc(1.0, 1e9) * 1e18, 1.0, 1e-15);
}

TEST(FormFactors, CoaxialDiscs) {
    const double r1 = 1.5, r2 = 0.8, h = 1.1;
    EXPECT_NEAR(coaxial_discs(r1, r2, h),
                2.0 / (r1 * r1) * integral(40, 0.0, r1, [&](double a) { return a * element_to_disc(r2, h, a); }),
                1e-14);
    EXPECT_NEAR(r1 * r1 * coaxial_discs(r1, r2, h), r2 * r2 * coaxial_discs(r2, r1, h), 1e-15);
    const double S = 1.0 + (r2 * r2 + h * h) / (r1 * r1); // as it is usually written
    EXPECT_NEAR(coaxial_discs(r1, r2, h), 0.5 * (S - std::sqrt(S * S - 4.0 * r2 * r2 / (r1 * r1))), 1e-15);
    EXPECT_NEAR(coaxial_discs(1.0, 1e-9, 1.0) * 1e18, 0.5, 1e-15) << "a tiny disc: as element_to_disc";
}

TEST(FormFactors, AnElementBeforeARectangle) {
    const Rectangle r{-0.4, 1.0, 0.3, 1.1};
    const double F = integral(30, r.x0, r.x1, [&](double x) {
        return integral(30, r.y0, r.y1, [&](double y) { return 1.0 / (pi * std::pow(1.0 + x * x + y * y, 2)); });
    });
    EXPECT_NEAR(element_to_rectangle(r, 1.0), F, 1e-14);
    EXPECT_NEAR(element_to_rectangle({-1e9, 1e9, -1e9, 1e9}, 1.0), 1.0, 1e-15);
}

/// A_ball F = ∫ over the disc of the form factor back, whatever the ball's radius.
TEST(FormFactors, BallAndDisc) {
    const double R = 2.0, h = 1.7;
    for (const double r : {0.1, 1.0, 1.7}) {
        const double power = integral(40, 0.0, R, [&](double u) { return 2.0 * pi * u * element_to_ball(r, h, u); });
        EXPECT_NEAR(4.0 * pi * r * r * ball_to_coaxial_disc(R, h), power, 1e-13);
    }
    EXPECT_NEAR(ball_to_coaxial_disc(R, h), 0.5 * (1.0 - 1.0 / std::sqrt(1.0 + R * R / (h * h))), 1e-15);
    EXPECT_NEAR(ball_to_coaxial_disc(1e12, 1.0), 0.5, 1e-12);
    EXPECT_THROW(element_to_ball(1.0, 0.9, 0.0), UsageError);
}

/// Wall and ends of a cylinder are closed; the ends are coaxial discs; the wall's elements add up.
TEST(FormFactors, Cylinder) {
    for (const double length : {0.01, 1.0, 30.0}) {
        const double r = 0.7, end = 0.5 * r / length * (1.0 - coaxial_discs(r, r, length)); // from the wall to an end
        EXPECT_NEAR(cylinder_to_itself(r, length) + 2.0 * end, 1.0, 1e-13);
        EXPECT_NEAR(end * length,
                    integral(60, 0.0, length, [&](double t) { return cylinder_element_to_section(r, t); }), 1e-12);
    }
    EXPECT_EQ(cylinder_element_to_section(1.0, 0.0), 0.5);
    const double X = 0.65;
    EXPECT_NEAR(cylinder_element_to_section(1.0, 1.3), (X * X + 0.5) / std::sqrt(X * X + 1.0) - X, 1e-15);
}

/// Of infinite surfaces, the kernel in the plane is cos cos/(2 r).
TEST(FormFactors, CrossedStringsByQuadrature) {
    const Eigen::Vector2d a0(0, 0), a1(1.2, 0.1), b0(0.3, 0.9), b1(1.9, 1.4);
    const auto normal = [](const Eigen::Vector2d& p, const Eigen::Vector2d& q) {
        return Eigen::Vector2d(p.y() - q.y(), q.x() - p.x()).normalized().eval();
    };
    const double F = integral(30, 0.0, 1.0, [&](double s) {
        return integral(30, 0.0, 1.0, [&](double t) {
            const Eigen::Vector2d d = b0 + t * (b1 - b0) - a0 - s * (a1 - a0);
            return std::abs(normal(a0, a1).dot(d) * normal(b0, b1).dot(d)) / (2.0 * std::pow(d.norm(), 3)) *
                   (b1 - b0).norm();
        });
    });
    EXPECT_NEAR(crossed_strings(a0, a1, b0, b1), F, 1e-13);
    EXPECT_EQ(crossed_strings(a0, a1, b1, b0), crossed_strings(a0, a1, b0, b1));
    EXPECT_NEAR((a1 - a0).norm() * crossed_strings(a0, a1, b0, b1), (b1 - b0).norm() * crossed_strings(b0, b1, a0, a1),
                1e-15);
    EXPECT_THROW(crossed_strings(a0, a1, {0.5, -1}, {0.5, 1}), UsageError);
}

/// The shelf is cut out of the plane by strings; with the opening it is closed.
TEST(FormFactors, Shelf) {
    for (const double b : {0.2, 1.0, 3.0}) {
        const double a = 1.4, g = b / a;
        const Eigen::Vector2d corner(0, 0), front(a, 0), top(0, b), top_front(a, b);
        const ShelfFormFactors F = shelf(a, b);
        EXPECT_NEAR(F.AB, 0.5 * (1.0 + g - std::sqrt(1.0 + g * g)), 1e-15);
        EXPECT_NEAR(F.AC, std::sqrt(1.0 + g * g) - g, 1e-15);
        EXPECT_NEAR(F.BA, 0.5 * (1.0 + 1.0 / g - std::sqrt(1.0 + 1.0 / (g * g))), 1e-15);
        EXPECT_NEAR(F.AB, crossed_strings(corner, front, corner, top), 1e-15);
        EXPECT_NEAR(F.AC, crossed_strings(corner, front, top, top_front), 1e-15);
        EXPECT_NEAR(F.BA, crossed_strings(corner, top, corner, front), 1e-15);
        EXPECT_NEAR(2.0 * F.AB + F.AC, 1.0, 1e-15); // the opening is like the back
        // Rectangles w wide miss at most what is more than w/2 to the side, of order 1/w.
        const double at_1e3 = opposite_rectangles(a, 1e3, b) - F.AC, at_1e4 = opposite_rectangles(a, 1e4, b) - F.AC;
        EXPECT_LT(std::abs(at_1e4), 0.15 * std::abs(at_1e3));
    }
}

TEST(BlockedRectangles, UnitSquares) {
    EXPECT_NEAR(blocked_rectangles({}, {}, 1.0, {0.0, 0.5, 0.0, 0.5}, 0.5), 0.1498686718, 1e-10);
}

/// What two halves of a blocker hide adds up to what the whole hides.
TEST(BlockedRectangles, PartsHideWhatTheWholeHides) {
    const Rectangle a{-0.2, 0.7, 0.1, 1.3}, b{0.2, 1.4, 0.0, 0.8};
    const double h = 0.9, at = 0.31, free = parallel_rectangles(a, b, h);
    const auto hidden = [&](const Rectangle& blocker) { return free - blocked_rectangles(a, b, h, blocker, at); };
    EXPECT_NEAR(hidden({0.1, 0.37, 0.2, 0.7}) + hidden({0.37, 0.8, 0.2, 0.7}), hidden({0.1, 0.8, 0.2, 0.7}), 1e-13);
    EXPECT_GT(hidden({0.1, 0.37, 0.2, 0.7}), 0.01);
    EXPECT_EQ(hidden({5.0, 6.0, 0.2, 0.7}), 0.0) << "out of the way";
    EXPECT_NEAR(hidden({-2.0, 3.0, -2.0, 3.0}), free, 1e-12) << "hides all";
}

TEST(BlockedRectangles, Reciprocity) {
    const Rectangle a{-0.2, 0.7, 0.1, 1.3}, b{0.2, 1.4, 0.0, 0.8}, blocker{0.1, 0.5, 0.3, 0.6};
    for (const double at : {0.05, 0.3, 0.8}) {
        EXPECT_NEAR(a.area() * blocked_rectangles(a, b, 0.9, blocker, at),
                    b.area() * blocked_rectangles(b, a, 0.9, blocker, 0.9 - at), 1e-12)
            << at;
    }
}

/// Random pairs of points, each tried against the blocker: within five standard errors (one run in a million fails, and
/// the stream is always the same).
TEST(BlockedRectangles, RandomPairsOfPoints) {
    const Rectangle a{-0.2, 0.7, 0.1, 1.3}, b{0.2, 1.4, 0.0, 0.8}, blocker{0.1, 0.5, 0.3, 0.6};
    const double h = 0.9, at = 0.31;
    RandomStream stream(1, "pairs");
    const auto point = [&](const Rectangle& r) {
        const double x = r.x0 + stream.uniform() * (r.x1 - r.x0);
        return Eigen::Vector2d(x, r.y0 + stream.uniform() * (r.y1 - r.y0));
    };
    const int count = 400000;
    double sum = 0.0, squares = 0.0;
    for (int i = 0; i < count; ++i) {
        const Eigen::Vector2d p = point(a), q = point(b), m = p + at / h * (q - p);
        const bool blocked = m.x() > blocker.x0 && m.x() < blocker.x1 && m.y() > blocker.y0 && m.y() < blocker.y1;
        const double square = h * h + (q - p).squaredNorm(),
                     value = blocked ? 0.0 : b.area() * h * h / (pi * square * square);
        sum += value;
        squares += value * value;
    }
    const double mean = sum / count, error = std::sqrt((squares / count - mean * mean) / count);
    EXPECT_NEAR(blocked_rectangles(a, b, h, blocker, at), mean, 5.0 * error);
    EXPECT_LT(error, 2e-3 * mean) << "too few to tell";
}

TEST(FormFactors, BadLengthsAreRefused) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const double bad : {0.0, -1.0, nan, std::numeric_limits<double>::infinity()}) {
        EXPECT_THROW(opposite_rectangles(bad, 1.0, 1.0), UsageError);
        EXPECT_THROW(opposite_rectangles(1.0, 1.0, bad), UsageError);
        EXPECT_THROW(rectangles_with_common_edge(1.0, bad, 1.0), UsageError);
        EXPECT_THROW(coaxial_discs(1.0, bad, 1.0), UsageError);
        EXPECT_THROW(element_to_disc(1.0, bad), UsageError);
        EXPECT_THROW(element_to_rectangle({}, bad), UsageError);
        EXPECT_THROW(element_to_ball(bad, 1.0, 0.0), UsageError);
        EXPECT_THROW(ball_to_coaxial_disc(bad, 1.0), UsageError);
        EXPECT_THROW(cylinder_to_itself(1.0, bad), UsageError);
        EXPECT_THROW(cylinder_element_to_section(bad, 1.0), UsageError);
        EXPECT_THROW(shelf(1.0, bad), UsageError);
        EXPECT_THROW(blocked_rectangles({}, {}, 1.0, {}, bad), UsageError);
    }
    EXPECT_THROW(perpendicular_rectangles({-0.1, 1.0, 0.0, 1.0}, {}), UsageError);
    EXPECT_THROW(parallel_rectangles({1.0, 0.0, 0.0, 1.0}, {}, 1.0), UsageError);
    EXPECT_THROW(blocked_rectangles({}, {}, 1.0, {}, 1.0), UsageError);
    EXPECT_THROW(crossed_strings({0, 0}, {0, 0}, {1, 0}, {1, 1}), UsageError);
    EXPECT_THROW(element_to_disc(1.0, 1.0, -1.0), UsageError);
}

} // namespace
} // namespace difusa::references_form_factors_test
