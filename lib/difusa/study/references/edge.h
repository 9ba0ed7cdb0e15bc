// Light near the edge where two walls meet.
#pragma once

namespace difusa {

/// The symbol of the integral equation at an edge of 90° that is infinite along it: an element at the distance s from
/// the edge receives s t / (2 (s² + t²)^(3/2)) per length from distances t of the other wall, and light like t^gamma
/// is carried to
///     ∫_0^∞ s t^(1+gamma) / (2 (s² + t²)^(3/2)) dt = K(gamma) s^gamma,   K(gamma) = B(1 + gamma/2, (1 - gamma)/2) / 4,
/// with the beta function B. K(0) = 1/2, the form factor; K rises to infinity at 1. Throws UsageError unless
/// -2 < gamma < 1.
double edge_symbol(double gamma);

/// The exponent of the radiosity of two such walls, lit alike and of reflectance rho, at the distance d from the edge,
///     B(d) = B(0) + c d^gamma + O(d³):
/// what is left of the light once B(0) is taken away reproduces itself, rho K(gamma) = 1. (The next root of this
/// equation, with K continued, is between 3 and 5; those between 1 and 3, where K is negative, belong to what differs
/// between the walls.) It falls from 1 for dark walls to 0.536 for white ones, so the derivative of the light is
/// infinite at the edge. Throws UsageError unless 0 < rho <= 1.
double edge_exponent(double rho);

} // namespace difusa
