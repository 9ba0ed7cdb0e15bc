#include <difusa/core/box_tree.h>

#include <algorithm>
#include <utility>

namespace difusa {

BoxTree::BoxTree(const std::vector<Box>& boxes, const std::vector<Index>& items) {
    entries_.reserve(boxes.size());
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        entries_.push_back({boxes[i], items[i]});
    }
    if (!entries_.empty()) {
        // Halving goes on until there are at most leaf entries, so that each leaf has at least half as many.
        nodes_.reserve(4 * entries_.size() / leaf + 1);
        build(0, entries_.size());
    }
}

void BoxTree::build(std::size_t first, std::size_t last) {
    const std::size_t number = nodes_.size();
    Node& node = nodes_.emplace_back();
    for (std::size_t i = first; i < last; ++i) {
        node.box.extend(entries_[i].box);
    }
    node.first = static_cast<Index>(first);
    node.last = static_cast<Index>(last);
    if (last - first <= leaf) {
        return;
    }
    Eigen::Index axis = 0;
    node.box.sizes().maxCoeff(&axis);
    const std::size_t middle = first + (last - first) / 2;
    const auto at = [&](std::size_t i) { return entries_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(first), at(middle), at(last), [axis](const Entry& a, const Entry& b) {
        const double x = a.box.min()[axis] + a.box.max()[axis], y = b.box.min()[axis] + b.box.max()[axis];
        return x < y || (x == y && a.item < b.item);
    });
    build(first, middle);
    nodes_[number].right = static_cast<Index>(nodes_.size());
    build(middle, last);
}

} // namespace difusa
