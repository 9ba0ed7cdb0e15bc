#include <difusa/rays/visible_part.h>

#include <algorithm>
#include <cmath>
#include <span>

namespace difusa {

namespace {

/// Polygons with more corners are divided before they are clipped by the edges of one more blocker.
constexpr std::size_t many_corners = FlatPolygon::capacity - 2 * VisiblePart::most_corners;
static_assert(many_corners >= 6);

/// Of an edge, relative to its distance: the direction of shorter ones is lost to rounding.
constexpr double shortest = 0x1p-40;

} // namespace

VisiblePart::Node::Node(const FlatPolygon& piece) : polygon(piece), centre(piece.mean_corner()) {
    double squared = 0.0;
    for (const Vec3& corner : piece.corners()) {
        squared = std::max(squared, (corner - centre).squaredNorm());
    }
    radius = std::sqrt(squared);
}

void VisiblePart::set(const FlatPolygon& polygon) {
    nodes_.clear();
    nodes_.emplace_back(polygon);
    count_ = 1;
}

/// Whether one of the planes parts it from what they enclose.
bool VisiblePart::is_apart(const Node& node) const {
    return std::any_of(sides_.begin(), sides_.end(),
                       [&](const Plane& side) { return side.height(node.centre) <= -node.radius; }) ||
           std::any_of(sides_.begin(), sides_.end(), [&](const Plane& side) {
               const std::span<const Vec3> corners = node.polygon.corners();
               return std::all_of(corners.begin(), corners.end(),
                                  [&](const Vec3& corner) { return side.height(corner) <= 0.0; });
           });
}

void VisiblePart::add(const FlatPolygon& piece) {
    if (piece.size() <= many_corners) {
        parts_.push_back(piece);
    } else {
        for (const FlatPolygon& half : piece.halves()) {
            parts_.push_back(half);
        }
    }
}

/// What the planes leave of a piece. False if nothing of it is hidden.
bool VisiblePart::cut(const FlatPolygon& piece) {
    FlatPolygon inside = piece;
    for (const Plane& side : sides_) {
        inside = inside.above(side, 0.0);
        if (inside.empty()) {
            return false;
        }
    }
    inside = piece;
    parts_.clear();
    for (const Plane& side : sides_) {
        const FlatPolygon outside = inside.above(side, 0.0, -1.0);
        if (!outside.empty()) {
            add(outside);
            inside = inside.above(side, 0.0);
        }
    }
    return true;
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
    bool any = false;
    open_.assign(1, 0);
    while (!open_.empty()) {
        const std::size_t at = open_.back();
        open_.pop_back();
        if (is_apart(nodes_[at])) {
            continue;
        }
        if (nodes_[at].cut) {
            for (std::size_t part = 0; part < nodes_[at].parts; ++part) {
                open_.push_back(nodes_[at].first + part);
            }
        } else if (cut(nodes_[at].polygon)) {
            any = true;
            nodes_[at].cut = true;
            nodes_[at].first = nodes_.size();
            nodes_[at].parts = parts_.size();
            count_ += parts_.size() - 1;
            for (const FlatPolygon& part : parts_) {
                nodes_.emplace_back(part);
            }
        }
    }
    return any;
}

} // namespace difusa
