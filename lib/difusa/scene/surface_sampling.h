// Random points on a surface.
#pragma once

#include <difusa/core/random.h>
#include <difusa/scene/mesh.h>

#include <vector>

namespace difusa {

/// `count` points, each uniform over the surface by area, one from each of `count` equal shares of the area in the
/// order of the triangles: sums over them have no more, and mostly less, variance than sums over independent points.
std::vector<SurfacePoint> even_points(const Mesh& mesh, std::size_t count, RandomStream stream);

/// x, or if it is on an edge or within a 2^-16 part of the triangle of one, a place so far inside, so that rays do not
/// start on an edge. The normal is kept.
SurfacePoint inset(const Mesh& mesh, const SurfacePoint& x);

} // namespace difusa
