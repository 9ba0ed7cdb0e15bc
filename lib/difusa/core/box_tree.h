// Boxes in space, found by overlap with a box.
#pragma once

#include <difusa/core/types.h>

#include <Eigen/Geometry>

#include <array>
#include <cstddef>
#include <vector>

namespace difusa {

/// A binary tree of boxes, split at the median along the longest side. Boxes are closed: touching boxes overlap.
class BoxTree {
  public:
    using Box = Eigen::AlignedBox3d;

    BoxTree() = default;

    /// boxes[i] has the number items[i].
    BoxTree(const std::vector<Box>& boxes, const std::vector<Index>& items);

    bool empty() const { return nodes_.empty(); }

    /// Calls `act(item, box)` for each box that overlaps `with`, until it returns true. True if it did.
    template <class Act> bool visit(const Box& with, const Act& act) const {
        const auto overlaps = [&](const Box& box) { return box.intersects(with); };
        return visit_boxes(overlaps, act);
    }

    /// The same for each box for which `meets(box)` is true; it must be true of every box that contains such a box.
    template <class Meets, class Act> bool visit_where(const Meets& meets, const Act& act) const {
        return visit_boxes(meets, [&](Index item, const Box&) { return act(item); });
    }

  private:
    template <class Meets, class Act> bool visit_boxes(const Meets& meets, const Act& act) const {
        if (nodes_.empty()) {
            return false;
        }
        std::array<Index, 64> open; // NOLINT: filled before use; the depth is at most 32, with one pending node at each
        std::size_t count = 0;
        open[count++] = 0;
        while (count > 0) {
            const Node& node = nodes_[open[--count]];
            if (!meets(node.box)) {
                continue;
            }
            if (node.right == none) {
                for (Index i = node.first; i < node.last; ++i) {
                    if (meets(entries_[i].box) && act(entries_[i].item, entries_[i].box)) {
                        return true;
                    }
                }
                continue;
            }
            open[count++] = node.right;
            open[count++] = static_cast<Index>(&node - nodes_.data()) + 1; // the left child follows
        }
        return false;
    }

    static constexpr std::size_t leaf = 4; ///< entries at most

    struct Entry {
        Box box;
        Index item = 0;
    };
    struct Node {
        Box box;
        Index first = 0, last = 0; ///< its entries
        Index right = none;        ///< none: a leaf
    };
    /// Adds the node of these entries, and those below it.
    void build(std::size_t first, std::size_t last);

    std::vector<Node> nodes_; ///< each before its children, the left one immediately
    std::vector<Entry> entries_;
};

} // namespace difusa
