// What of a polygon is not hidden by convex ones in front of it.
#pragma once

#include <difusa/rays/flat_polygon.h>

#include <cstddef>
#include <vector>

namespace difusa {

/// The part of a polygon that a point sees, as convex pieces. Scratch of one thread.
class VisiblePart {
  public:
    /// Of a blocker, before it is clipped by two planes.
    static constexpr std::size_t most_corners = 12;

    /// Nothing is in front of it yet.
    void set(const FlatPolygon& polygon);

    /// Takes away what a blocker hides from x: what lies inside all planes through x and its edges. It is wholly in
    /// front of the polygon and above the horizon of x. `plane`: its own, with a unit normal; seen from within
    /// `rounding` of this it hides nothing. True if it hides something.
    ///
    /// Pieces are the leaves of a tree, in which each piece that was cut has its parts below it: a blocker is compared
    /// with few of them, however many there are.
    bool hide(const Vec3& x, const FlatPolygon& blocker, const Plane& plane, double rounding);

    std::size_t count() const { return count_; } ///< of pieces
    bool empty() const { return count_ == 0; }

    /// Calls `act(polygon)` for each piece.
    template <class Act> void for_pieces(const Act& act) const {
        for (const Node& node : nodes_) {
            if (!node.cut) {
                act(node.polygon);
            }
        }
    }

  private:
    struct Node {
        FlatPolygon polygon;
        Vec3 centre; ///< of a ball that contains it
        double radius = 0.0;
        bool cut = false;                 ///< it is no piece any more
        std::size_t first = 0, parts = 0; ///< what is left of it
        explicit Node(const FlatPolygon& piece);
    };
    bool is_apart(const Node& node) const;
    bool cut(const FlatPolygon& piece);
    void add(const FlatPolygon& piece);

    std::vector<Node> nodes_;
    std::size_t count_ = 0;
    std::vector<std::size_t> open_;  ///< nodes to be looked at
    std::vector<FlatPolygon> parts_; ///< of one piece
    std::vector<Plane> sides_;       ///< through x and the edges of a blocker
};

} // namespace difusa
