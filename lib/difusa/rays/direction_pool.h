// Directions for every site at the cost of a few: a pool of scrambled sets, each rotated by a site-specific angle.
#pragma once

#include <difusa/core/frame.h>
#include <difusa/rays/directions.h>
#include <difusa/rays/visibility.h>

#include <cstdint>
#include <span>
#include <vector>

namespace difusa {

/// Rotating a set about the normal preserves its weights and its stratification, so every site has its own random set;
/// sites may share a set, but never with the same rotation. A fixed set (Directions::is_fixed) is used as it is.
class DirectionPool {
  public:
    DirectionPool(const Directions& directions, std::size_t count, std::uint64_t seed);

    /// Number of directions in a set. The weights of each set are multiples of 2^-52 that sum to exactly 1, whatever
    /// the order of summation; unless they are all 1 / count().
    std::size_t count() const { return sets_.front().direction.size(); }

    /// True if all directions of all sets have the weight 1 / count().
    bool equal_weights() const { return equal_weights_; }

    /// Writes `count()` rays that leave site number `site` at x (unit directions), and returns their weights.
    std::span<const double> rays(const SurfacePoint& x, std::size_t site, std::span<Ray> rays) const;

  private:
    std::vector<DirectionSet> sets_;
    std::uint64_t seed_;
    bool turned_; ///< about the normal, by a random angle for each site
    bool equal_weights_ = true;
};

} // namespace difusa
