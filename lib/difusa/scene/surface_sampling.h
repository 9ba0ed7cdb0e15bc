// Random points on a surface.
#pragma once

#include <difusa/core/random.h>
#include <difusa/scene/mesh.h>

#include <vector>

namespace difusa {

/// `count` points, each uniform over the surface by area, one from each of `count` equal shares of the area in the
/// order of the triangles: sums over them have no more, and mostly less, variance than sums over independent points.
std::vector<SurfacePoint> even_points(const Mesh& mesh, std::size_t count, RandomStream stream);

/// x moved into the inside of its triangle by about a 2^-12 part of the way to the centroid, so that rays that start
/// there do not start on an edge. The normal is kept.
SurfacePoint inset(const Mesh& mesh, const SurfacePoint& x);

} // namespace difusa
