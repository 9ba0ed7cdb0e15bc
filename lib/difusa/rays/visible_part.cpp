#include <difusa/rays/visible_part.h>

#include <cmath>
#include <utility>

namespace difusa {

namespace {

/// Polygons with more corners are divided before they are clipped by the edges of one more blocker.
constexpr std::size_t many_corners = FlatPolygon::capacity - 2 * VisiblePart::most_corners;
static_assert(many_corners >= 6);

/// Of an edge, relative to its distance: the direction of shorter ones is lost to rounding.
constexpr double shortest = 0x1p-40;

} // namespace

void VisiblePart::keep(const FlatPolygon& piece) {
    if (piece.size() <= many_corners) {
        next_.push_back(piece);
    } else {
        for (const FlatPolygon& half : piece.halves()) {
            next_.push_back(half);
        }
    }
}

bool VisiblePart::hide(const Vec3& x, const FlatPolygon& blocker, const Plane& plane, double rounding) {
    const double height = plane.height(x);
    if (std::abs(height) <= rounding) {
        return false; // seen edge-on
    }
    sides_.clear();
    for (std::size_t k = 0; k < blocker.size(); ++k) {
        const Vec3 &from = blocker[k], &to = blocker.next(k);
        // Inwards is to the left of the edge seen from the front.
        const Vec3 normal = (from - x).cross(to - x) * (height > 0.0 ? -1.0 : 1.0);
        const double length = normal.norm();
        if (length > 0.0 && (to - from).norm() > shortest * (from - x).norm()) {
            sides_.push_back({normal / length, normal.dot(x) / length});
        }
    }
    if (sides_.size() < 3) {
        return false; // of a blocker without area
    }
    next_.clear();
    bool any = false;
    for (const FlatPolygon& piece : pieces_) {
        FlatPolygon inside = piece;
        for (const Plane& side : sides_) {
            inside = inside.above(side, 0.0);
            if (inside.empty()) {
                break;
            }
        }
        if (inside.empty()) {
            next_.push_back(piece); // nothing of it is hidden
            continue;
        }
        any = true;
        inside = piece;
        for (const Plane& side : sides_) {
            const FlatPolygon outside = inside.above(side, 0.0, -1.0);
            if (!outside.empty()) {
                keep(outside);
                inside = inside.above(side, 0.0);
            }
        }
    }
    std::swap(pieces_, next_);
    return any;
}

} // namespace difusa
