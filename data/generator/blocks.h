// Buildings of upright blocks: solids are filled in and carved out, and the resulting surface between solid and air is
// watertight, without hidden faces, and with whole edges meeting whole edges.
#pragma once

#include "surface.h"

#include <optional>
#include <vector>

namespace scenes {

/// Rounded to a micrometre, so that equal positions have equal coordinates, whatever sums produced them.
Vector rounded(const Vector& v);

class Blocks {
  public:
    /// Coordinates are rounded as above. Everything is within the box from `low` to `high`, initially air. No faces are
    /// built on the sides of the box itself: solids that touch it continue outside, air that touches it is open to the
    /// outside.
    Blocks(const Vector& low, const Vector& high);

    /// Makes the part of the box between two corners solid; later calls take precedence.
    void fill(const Vector& low, const Vector& high, unsigned material);

    /// Makes it air.
    void carve(const Vector& low, const Vector& high);

    /// Makes it solid except for half a cylinder along y whose axis runs along the middle of the bottom and whose
    /// diameter is the full width; it must be higher than that radius. No other block may end within it.
    void arch(const Vector& low, const Vector& high, int segments, unsigned material);

    /// Excludes it: no faces are built in it or towards it, and air next to it is open to it. For the outdoors, or for
    /// parts not made of blocks that continue the adjacent solids.
    void leave_out(const Vector& low, const Vector& high);

    /// Builds the surface: rectangles, and the triangles of arches.
    void add_to(Surface& surface) const;

  private:
    struct Step {
        Vector low, high;
        std::optional<unsigned> material; ///< none: air, or excluded
        int segments = 0;                 ///< of an arch
        bool left_out = false;
    };
    std::vector<Step> steps_;
};

} // namespace scenes
