// Form factors in closed form, and one with a blocker by high-order quadrature.
// F from 1 to 2 is the share of the light leaving 1 that arrives at 2; A_1 F_12 = A_2 F_21. All depend only on ratios
// of lengths. Formulas without attribution are those of J. R. Howell's "A Catalog of Radiation Heat Transfer
// Configuration Factors"; where differences would cancel they are rewritten. Every function throws UsageError unless
// its lengths are positive and finite.
#pragma once

#include <Eigen/Core>

namespace difusa {

/// [x0,x1] x [y0,y1].
struct Rectangle {
    double x0 = 0.0, x1 = 1.0, y0 = 0.0, y1 = 1.0;
    double area() const { return (x1 - x0) * (y1 - y0); }
};

/// From `from` in the plane z = 0 to `to` in the plane z = distance:
///     A F = sum of ± g(x_from - x_to, y_from - y_to) over the 16 pairs of corners, the sign that of its four indices,
///     g(u, v) = (1/2pi) (v √(u²+h²) atan(v/√(u²+h²)) + u √(v²+h²) atan(u/√(v²+h²)) - (h²/2) ln(u²+v²+h²)),
/// since the derivative of g twice by u and twice by v is the kernel h²/(pi (u²+v²+h²)²) (J. R. Ehlert and T. F. Smith,
/// J. Thermophysics and Heat Transfer 7, 1993). Absolute error about 1e-15 D²/A with the largest distance D.
double parallel_rectangles(const Rectangle& from, const Rectangle& to, double distance);

/// Equal rectangles a by b straight opposite, `distance` apart.
double opposite_rectangles(double a, double b, double distance);

/// From `from` in the plane z = 0, its x >= 0, to the rectangle in the plane x = 0 with the same y axis and z instead
/// of x, its z >= 0: like parallel rectangles with
///     g(q, v) = (1/4pi) (2 v √q atan(v/√q) - (q - v²)/2 ln(q + v²)),   q = x² + z²,   v = y_from - y_to,
/// whose derivative by x, z and the two y is the kernel x z/(pi (q+v²)²) (Ehlert and Smith, likewise).
double perpendicular_rectangles(const Rectangle& from, const Rectangle& to);

/// From a rectangle `edge` by `depth` to one of `edge` by `height` at right angles to it on their common edge.
double rectangles_with_common_edge(double edge, double depth, double height);

/// From a disc of radius r1 to one of radius r2, facing each other on one axis: with S = 1 + (r2² + h²)/r1²,
///     F = (S - √(S² - 4 (r2/r1)²)) / 2.
double coaxial_discs(double r1, double r2, double distance);

/// From an element to a disc of radius r in a plane parallel to it at the distance h, a >= 0 off the disc's axis:
///     F = (1 - (a² + h² - r²)/√((a² + h² + r²)² - 4 a² r²)) / 2;   on the axis r²/(h² + r²).
double element_to_disc(double r, double h, double a = 0.0);

/// From an element to a rectangle in a plane parallel to it at the distance h, its coordinates relative to the foot of
/// the element: sum of ± f over its corners,
///     f(X, Y) = (1/2pi) (X/√(1+X²) atan(Y/√(1+X²)) + Y/√(1+Y²) atan(X/√(1+Y²))),   X = x/h, Y = y/h.
double element_to_rectangle(const Rectangle& rectangle, double h);

/// From an element to a ball of radius r, entirely above its horizon, with its centre at height h and u >= 0 to the
/// side:
///     F = r² h / (h² + u²)^(3/2).   Throws UsageError if h < r.
double element_to_ball(double r, double h, double u);

/// From a ball to a disc of radius r whose axis passes through the ball's centre, at distance h from it; the ball's
/// radius, less than h, does not matter: F = (1 - 1/√(1 + (r/h)²)) / 2.
double ball_to_coaxial_disc(double r, double h);

/// From the inside of an open cylinder of radius r to itself: F = 1 + H - √(1 + H²), H = length/(2 r).
double cylinder_to_itself(double r, double length);

/// From an element inside a cylinder of radius r to its cross-section at the distance t >= 0 along the axis:
///     F = (X² + 1/2)/√(X² + 1) - X,   X = t/(2 r).
double cylinder_element_to_section(double r, double t);

/// In the plane, from the segment a0 a1 to b0 b1 (surfaces of infinite length): (crossed - uncrossed strings)/(2 |a|)
/// (H. C. Hottel). Throws UsageError if the line of one segment passes through the inside of the other.
double crossed_strings(const Eigen::Vector2d& a0, const Eigen::Vector2d& a1, const Eigen::Vector2d& b0,
                       const Eigen::Vector2d& b1);

/// The infinite shelf: floor A and ceiling C of depth a, b apart, and the back B between them (L 33), g = b/a:
///     F_AB = (1 + g - √(1+g²))/2,   F_AC = √(1+g²) - g,   F_BA = F_BC = (1 + 1/g - √(1+1/g²))/2.
struct ShelfFormFactors {
    double AB, AC, BA;
};
ShelfFormFactors shelf(double a, double b);

/// As parallel_rectangles, with a rectangle that blocks in the plane z = height between them. From a point x, y of
/// `from` the blocker's shadow on the plane of `to` is a rectangle, so
///     A F = A F_free - ∫ element_to_rectangle(shadow ∩ to) dx dy,
/// by Gauss-Legendre panels between the lines where an edge of the shadow passes an edge of `to`: error below 1e-12.
/// Unit squares at z = 0 and 1 with [0,1/2]² at z = 1/2 between them: 0.1498686718.
double blocked_rectangles(const Rectangle& from, const Rectangle& to, double distance, const Rectangle& blocker,
                          double height);

} // namespace difusa
