// Random points on a surface.
#pragma once

#include <difusa/core/random.h>
#include <difusa/mesh/mesh.h>

#include <cmath>
#include <span>
#include <vector>

namespace difusa {

/// A point on triangle t, uniform by area if u and v are uniform in [0, 1).
inline SurfacePoint uniform_point(const Mesh& mesh, Index t, double u, double v) {
    const double root = std::sqrt(u);
    return mesh.at(t, root * (1.0 - v), root * v);
}

/// Points of some triangles, uniform by area.
class TriangleSampler {
  public:
    /// Keeps references.
    TriangleSampler(const Mesh& mesh, std::span<const Index> triangles);

    bool empty() const { return triangles_.empty(); }
    double area() const { return empty() ? 0.0 : below_.back(); }

    /// Uniform if share, u and v are uniform in [0, 1). Not to be called if empty.
    SurfacePoint at(double share, double u, double v) const;

  private:
    const Mesh& mesh_;
    std::span<const Index> triangles_;
    std::vector<double> below_; ///< area of the triangles up to each
};

/// `count` points, each uniform over the surface by area, one from each of `count` equal shares of the area in the
/// order of the triangles: sums over them have at most, and usually less than, the variance of sums over independent
/// points. With shading normals.
std::vector<SurfacePoint> even_points(const Mesh& mesh, std::size_t count, RandomStream stream);

/// x, or if it is on an edge or within 2^-16 of the triangle's size of one, a point that far inside, so that rays do
/// not start on an edge; from edges that the surface crosses in one plane, 2^-26. At a corner, or within 2^-16 of one,
/// where the view depends on the direction from which one approaches, it is a point on the bisector of the angle that
/// the plane has there, however the plane is divided into triangles: it may be on another face than x. The normal is
/// kept. A point in mid-air is returned as it is.
SurfacePoint inset(const Mesh& mesh, const SurfacePoint& x);

} // namespace difusa
