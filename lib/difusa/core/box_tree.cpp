#include <difusa/core/box_tree.h>

#include <algorithm>
#include <functional>
#include <numeric>
#include <utility>

namespace difusa {

BoxTree::BoxTree(std::vector<Box> boxes, std::vector<Index> items) {
    constexpr std::size_t leaf = 4;
    std::vector<Index> order(boxes.size());
    std::iota(order.begin(), order.end(), Index{0});
    const std::function<void(std::size_t, std::size_t)> build = [&](std::size_t first, std::size_t last) {
        const std::size_t number = nodes_.size();
        Node node;
        for (std::size_t i = first; i < last; ++i) {
            node.box.extend(boxes[order[i]]);
        }
        node.first = static_cast<Index>(first);
        node.last = static_cast<Index>(last);
        nodes_.push_back(node);
        if (last - first <= leaf) {
            return;
        }
        Eigen::Index axis = 0;
        node.box.sizes().maxCoeff(&axis);
        const auto twice_centre = [&](Index i) { return boxes[i].min()[axis] + boxes[i].max()[axis]; };
        const std::size_t middle = first + (last - first) / 2;
        const auto at = [&](std::size_t i) { return order.begin() + static_cast<std::ptrdiff_t>(i); };
        std::nth_element(at(first), at(middle), at(last), [&](Index a, Index b) {
            const double x = twice_centre(a), y = twice_centre(b);
            return x < y || (x == y && a < b);
        });
        build(first, middle);
        nodes_[number].right = static_cast<Index>(nodes_.size());
        build(middle, last);
    };
    if (!boxes.empty()) {
        build(0, boxes.size());
    }
    for (const Index i : order) {
        boxes_.push_back(boxes[i]);
        items_.push_back(items[i]);
    }
}

} // namespace difusa
