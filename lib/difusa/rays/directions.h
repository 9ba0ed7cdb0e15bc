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

    /// A set of about `count` directions (exactly `count` if the construction allows it). Sets drawn from different
    /// streams are independent random scrambles, unless the construction is a fixed grid.
    virtual DirectionSet make(std::size_t count, RandomStream stream) const = 0;
};

} // namespace difusa
