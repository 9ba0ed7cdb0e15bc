// What of a polygon is not hidden by convex ones in front of it.
#pragma once

#include <difusa/rays/flat_polygon.h>

#include <cstddef>
#include <span>
#include <vector>

namespace difusa {

/// The part of a polygon that a point sees, as convex pieces. Scratch of one thread.
class VisiblePart {
  public:
    /// Of a blocker, before it is clipped by two planes.
    static constexpr std::size_t most_corners = 12;

    /// Nothing is in front of it yet.
    void set(const FlatPolygon& polygon) { pieces_.assign(1, polygon); }

    /// Takes away what a blocker hides from x: what lies inside all planes through x and its edges. It is wholly in
    /// front of the polygon and above the horizon of x. `plane`: its own, with a unit normal; seen from within
    /// `rounding` of this it hides nothing. True if it hides something.
    bool hide(const Vec3& x, const FlatPolygon& blocker, const Plane& plane, double rounding);

    std::span<const FlatPolygon> pieces() const { return pieces_; }

  private:
    void keep(const FlatPolygon& piece);

    std::vector<FlatPolygon> pieces_, next_;
    std::vector<Plane> sides_; ///< through x and the edges of a blocker
};

} // namespace difusa
