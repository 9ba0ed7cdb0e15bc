// The exchange area of two polygons with nothing between them, at the cost that an accuracy takes.
#pragma once

#include <difusa/form_factors/contour.h>

namespace difusa {

/// A polygon as one end of an exchange: with what its pairs need again and again.
struct PolygonEnd {
    FlatPolygon polygon;
    Plane plane;                ///< its own, the normal being the unit normal of the front
    Vec3 centre = Vec3::Zero(); ///< centroid
    double area = 0.0;
    double radius = 0.0; ///< distance of the farthest corner from the centroid

    PolygonEnd() = default;
    /// `normal`: unit, of the front. The area may be 0 where rounding leaves nothing.
    PolygonEnd(const FlatPolygon& corners, const Vec3& normal);
};

/// A_P F_PQ of two polygons, each wholly in front of the plane of the other, with an error of about `tolerance` at most
/// (an area): where they are far apart for their size, products of Gaussian rules on triangles with 1, 3 or 7 points;
/// else `contour_exchange`. The error of a rule of degree d is estimated as
///     c_d (R/D)^(d+1) A_P A_Q / (pi D²),   c_1 = 2.2, c_2 = 0.2, c_5 = 0.1,
/// D being the distance of the centroids and R the larger radius: four times the largest errors of thousands of random
/// pairs of triangles with D of at least 2.5 times the sum of the radii, from where on these rules are used.
Estimate unblocked_exchange(const PolygonEnd& P, const PolygonEnd& Q, double tolerance);

/// Points and weights (sum 1) in barycentric coordinates of a triangle.
struct TrianglePoint {
    double u, v, weight;
};

/// Gaussian rules on triangles of 1, 3 and 7 points, exact for polynomials of degree 1, 2 and 5 (J. Radon 1948). The
/// first point of the first and the last is the centroid.
std::span<const TrianglePoint> triangle_rule(std::size_t points);

} // namespace difusa
