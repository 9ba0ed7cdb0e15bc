// The nearest point on a surface among the triangles that face the same way.
#pragma once

#include <difusa/core/types.h>

#include <array>
#include <memory>
#include <vector>

namespace difusa {

/// A tree over triangles. Queries may run in parallel.
class NearestSurface {
  public:
    /// A query point and its orientation.
    struct Query {
        Vec3 position;
        Vec3 normal; ///< unit: only triangles that turn from it by less than 90° are candidates; or zero: all are
        Vec3 toward; ///< a point on the side that the query belongs to, see `nearest`
    };

    struct Place {
        Index triangle = none; ///< none: no triangle faces that way
        double distance = 0.0;
        std::array<double, 3> weight{}; ///< of the triangle's corners, none negative, sum 1
    };

    /// `triangles` #T by 3: corners in `points` #P, all in range and finite. Zero-area triangles are skipped.
    NearestSurface(std::vector<Vec3> points, std::vector<std::array<Index, 3>> triangles);
    ~NearestSurface();
    NearestSurface(NearestSurface&&) noexcept;
    NearestSurface& operator=(NearestSurface&&) noexcept;

    /// The point nearest to `position` on the triangles that face the query's way.
    ///
    /// Among triangles that are equally near to within the rounding of coordinates (the position lies on their edge),
    /// the one nearest to `toward` is taken, then the one with the lower number: where the field jumps across an edge,
    /// at a crease or between materials, the query's side counts.
    Place nearest(const Query& query) const;

  private:
    struct Tree;
    std::unique_ptr<Tree> tree_;
};

/// Barycentric weights of the point of triangle a b c nearest to p. As exact as the triangle's normal: even for
/// needles, whose area would be lost in products of lengths.
std::array<double, 3> nearest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

} // namespace difusa
