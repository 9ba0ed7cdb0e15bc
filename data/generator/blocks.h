// Buildings of upright blocks: solids are filled in and carved out, and the surface between solid and air comes out
// watertight, without hidden faces, and with whole edges meeting whole edges.
#pragma once

#include "surface.h"

#include <optional>
#include <vector>

namespace scenes {

/// Rounded to a micrometre, so that what ends at one place ends at the same number, whatever sums led there.
Vector rounded(const Vector& v);

class Blocks {
  public:
    /// Coordinates are rounded as above. All within the box from `low` to `high`, air at first. Nothing is built
    /// on the sides of the box itself: solids that touch it go on outside, air that touches it is open to the outside.
    Blocks(const Vector& low, const Vector& high);

    /// Makes the part of the box between two corners solid; later calls win.
    void fill(const Vector& low, const Vector& high, unsigned material);

    /// Makes it air.
    void carve(const Vector& low, const Vector& high);

    /// Makes it solid but for half a cylinder along y whose axis is the middle of the bottom and whose diameter is the
    /// whole width; it must be higher than that radius. No other block may end within it.
    void arch(const Vector& low, const Vector& high, int segments, unsigned material);

    /// Leaves it to others: nothing is built in it or towards it, and air beside it is open to it. Outdoors, or
    /// something that is not made of blocks and continues the solids beside it.
    void leave_out(const Vector& low, const Vector& high);

    /// Builds the surface: rectangles, and the triangles of arches.
    void add_to(Surface& surface) const;

  private:
    struct Step {
        Vector low, high;
        std::optional<unsigned> material; ///< none: air, or left out
        int segments = 0;                 ///< of an arch
        bool left_out = false;
    };
    std::vector<Step> steps_;
};

} // namespace scenes
