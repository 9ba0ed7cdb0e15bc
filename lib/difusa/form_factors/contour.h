// The exchange area of two polygons that see each other completely, by Stokes' theorem.
#pragma once

#include <difusa/rays/flat_polygon.h>

namespace difusa {

/// A value and how far it may be from the truth.
struct Estimate {
    double value = 0.0, error = 0.0;

    Estimate& operator+=(const Estimate& other) {
        value += other.value;
        error += other.error;
        return *this;
    }
};

/// The exchange area A_P F_PQ = A_Q F_QP of two polygons, each wholly in front of the plane of the other (touching it
/// at most), with nothing between them, in the square of the unit of length:
///     A_P F_PQ = (1/2pi) ∮∮ ln|x - y| dx·dy
/// over both boundaries (Goral, Torrance, Greenberg and Battaile 1984; L 36). Of each pair of edges the inner integral
/// is elementary; so are both where the edges share an end point. The outer one otherwise is by Gauss-Legendre on
/// intervals no longer than their distance from where the inner one is singular, with as many nodes as make the error
/// of each pair at most `accuracy` times its scale, the product of both lengths. The error is that sum and rounding.
///
/// Polygons may share edges or vertices (equal coordinates), touch, and be nearly coplanar. Invariant under translation
/// and scaling of the coordinates, up to rounding.
Estimate contour_exchange(const FlatPolygon& P, const FlatPolygon& Q, double accuracy = 1e-14);

} // namespace difusa
