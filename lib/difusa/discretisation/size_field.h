// How far apart sites should be, from place to place.
#pragma once

#include <difusa/mesh/mesh.h>
#include <difusa/mesh/point_tree.h>

#include <cstddef>
#include <optional>
#include <vector>

namespace difusa {

/// A spacing at every point of the surface: given at some points, it grows by `slope` per unit of distance from them,
///     s(x) = min_j (s_j + slope |x - p_j|)   over the points on the region of x,
/// up to the largest. Sites are placed at spacings of powers of 2^(1/2), which s(x) is rounded to.
class SizeField {
  public:
    static constexpr double slope = 0.3;
    static constexpr double root_of_2 = 1.4142135623730951;
    static constexpr double rounding = 1.189207115002721; ///< 2^(1/4): from the spacing of a level to where it ends

    /// Sites placed by refine_sites (poisson_disk.h) are no farther from x than this times s(x).
    static constexpr double cover = root_of_2 / (rounding - slope / 6.0);

    /// `sizes`: s_j, at most `largest`. `region_count`: of the mesh.
    SizeField(std::vector<SurfacePoint> points, const std::vector<Index>& region, std::vector<double> sizes,
              double largest, Index region_count);

    /// Other sizes at the same points.
    void assign(std::vector<double> sizes);

    /// s(x); `largest` on a region without points.
    double at(const Vec3& x, Index region) const;

    /// An upper bound of s(x) below `limit`, if s(x) is below it up to rounding, else `limit`: known faster than s(x).
    double bound_below(double limit, const Vec3& x, Index region) const;

    /// The spacing that sites are placed at around x: s(x), rounded.
    double placed_at(const Vec3& x, Index region) const { return rounded(largest_, at(x, region)); }

    double largest() const { return largest_; }
    double smallest() const { return smallest_; }

    /// How far the element of a site at x has to reach: a point y whose nearest site this is, at a distance d of at
    /// most cover s(y), where s(y) <= s(x) + slope d, has d <= cover s(x) / (1 - cover slope).
    double reach(const Vec3& x, Index region) const { return cover / (1.0 - cover * slope) * at(x, region); }

    /// The spacing of a level, from 0.
    static double spacing_of(double largest, int level);

    /// The spacing that sites are placed at where s is `size`.
    static double rounded(double largest, double size);

  private:
    std::vector<SurfacePoint> points_;
    std::vector<Index> region_;                   ///< of the points
    std::vector<double> sizes_, least_;           ///< of the points; the least of each region, or the largest
    std::vector<std::optional<PointTree>> trees_; ///< #regions
    double largest_, smallest_;
};

} // namespace difusa
