// What a point sees of a polygon past the faces of a mesh, in closed form, where few of them are in the way.
#pragma once

#include <difusa/rays/shaft.h>
#include <difusa/rays/visible_part.h>

#include <cstddef>
#include <span>
#include <vector>

namespace difusa {

/// One polygon after another; scratch of one thread.
class PolygonInSight {
  public:
    /// Triangles that may hide parts of a polygon, and its parts in sight, beyond which `look` gives up.
    struct Limits {
        std::size_t blockers = 24, parts = 32;
    };

    enum class Extent {
        whole,  ///< nothing is in the way
        pieces, ///< what is left, which may be nothing
        unknown ///< too much is in the way
    };

    /// Looks from x at a convex polygon of at most Shafts::most_corners in the plane `plane`, of unit normal,
    /// counterclockwise as seen from its front, which x is before. Faces in the planes of the polygon and of the face
    /// of x hide nothing. Exact to rounding.
    Extent look(const Shafts& shafts, const SurfacePoint& x, std::span<const Vec3> polygon, const Plane& plane,
                const Limits& limits);

    /// The faces that may hide parts of it; none if they are too many.
    const std::vector<Index>& blockers() const { return blockers_; }

    /// The sum of `value(corners)` over the convex pieces in sight. Only after `look` has found pieces.
    template <class Value> double sum(const Value& value) const {
        double sum = 0.0;
        visible_.for_pieces([&](const FlatPolygon& piece) { sum += value(piece.corners()); });
        return sum;
    }

  private:
    std::vector<Index> blockers_;
    VisiblePart visible_;
};

} // namespace difusa
