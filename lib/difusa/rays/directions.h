// Plugin kind "directions": sets of directions over the hemisphere with weights for cosine-weighted means.
#pragma once

#include <difusa/core/random.h>
#include <difusa/core/types.h>

#include <vector>

namespace difusa {

/// sum_d weight[d] f(direction[d]) approximates (1/pi) ∫ f(w) max(0, w_z) dw over the hemisphere around +z.
struct DirectionSet {
    std::vector<Vec3> direction; ///< unit, z > 0
    std::vector<double> weight;  ///< positive, sum 1
};

class Directions {
  public:
    virtual ~Directions() = default;

    /// A set of about `count` directions (exactly `size(count)`). Sets drawn from different
    /// streams are independent random scrambles, unless the construction is a fixed grid.
    virtual DirectionSet make(std::size_t count, RandomStream stream) const = 0;

    /// The number of directions in a set of about `count`.
    virtual std::size_t size(std::size_t count) const { return count; }

    /// True if all directions of a set may be expected to have the same weight: their hits take less memory.
    virtual bool equal_weights() const { return true; }

    /// True if there is one set only, which every point uses as it is, not even turned about the normal. Its errors are
    /// not noise: they repeat from point to point (aliasing), and no second set tells them.
    virtual bool is_fixed() const { return false; }
};

} // namespace difusa
