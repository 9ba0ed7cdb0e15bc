// Checks for mistakes in a mesh file that no repair could guess the meaning of.
#pragma once

#include <difusa/repair/polygon_soup.h>

namespace difusa {

/// Throws InputError naming file, line or face, the bad value and the remedy for the first of these:
///   - a face that refers to a point the file does not have;
///   - a coordinate of a face's corner that is NaN, infinite, or so large (beyond 1e75) that areas would overflow;
///   - a material used by a face with a reflectance outside [0,1], or an emission that is negative or not finite;
///   - a texture that takes a reflectance above 1, or a corner without texture coordinates on a textured face;
///   - a corner of a face with vertex colours whose colour is outside [0,1].
/// Throws ResourceError if the soup has more corners than 32-bit numbers can distinguish.
void check_soup(const PolygonSoup& soup);

/// Only the first of these checks: what must hold before the faces of several soups are combined.
void check_indices(const PolygonSoup& soup);

} // namespace difusa
