#include <difusa/form_factors/target_tree.h>

#include <algorithm>
#include <numeric>

namespace difusa {

TargetTree::TargetTree(const Mesh& mesh, const std::vector<Index>& parts, const std::vector<Index>& rank, Index most)
    : order_(mesh.triangles.size()) {
    std::iota(order_.begin(), order_.end(), Index{0});
    std::stable_sort(order_.begin(), order_.end(), [&](Index a, Index b) { return parts[a] < parts[b]; });
    nodes_.reserve(order_.size());
    if (!order_.empty()) {
        build(mesh, parts, rank, 0, static_cast<Index>(order_.size()), most);
    }
}

void TargetTree::build(const Mesh& mesh, const std::vector<Index>& parts, const std::vector<Index>& rank, Index first,
                       Index last, Index most) {
    const auto number = static_cast<Index>(nodes_.size());
    nodes_.emplace_back();
    Eigen::AlignedBox3d box, centres;
    Index highest = 0;
    for (Index i = first; i < last; ++i) {
        const Eigen::AlignedBox3d around = mesh.box(order_[i]);
        box.extend(around);
        centres.extend(around.center());
        highest = std::max(highest, rank[order_[i]]);
    }
    const Index front = order_[first];
    Node node;
    for (unsigned k = 0; k < 8; ++k) {
        const Vec3 &low = box.min(), &high = box.max();
        node.corner[k] = Vec3((k & 1U) != 0 ? high.x() : low.x(), (k & 2U) != 0 ? high.y() : low.y(),
                              (k & 4U) != 0 ? high.z() : low.z());
    }
    const auto in_first_part = [&](Index t) { return parts[t] == parts[front]; };
    const auto begin = order_.begin() + first, end = order_.begin() + last;
    node.flat = std::all_of(begin, end, in_first_part);
    node.plane = {mesh.normals[front], mesh.normals[front].dot(mesh.corner(front, 0))};
    node.first = first;
    node.last = last;
    node.highest = highest;
    nodes_[number] = node;
    if (last - first <= most) {
        return;
    }
    Index middle = first + (last - first) / 2;
    Eigen::Index axis = 0;
    centres.sizes().maxCoeff(&axis);
    const auto by_place = [&](Index a, Index b) {
        const double at_a = mesh.box(a).center()[axis], at_b = mesh.box(b).center()[axis];
        return at_a != at_b ? at_a < at_b : a < b;
    };
    const auto share = std::count_if(begin, end, in_first_part);
    if (!node.flat && 4 * share >= last - first) { // a large flat part: by itself
        const auto bound = std::stable_partition(begin, end, in_first_part);
        middle = static_cast<Index>(bound - order_.begin());
    } else {
        std::nth_element(begin, order_.begin() + middle, end, by_place);
    }
    build(mesh, parts, rank, first, middle, most);
    nodes_[number].right = static_cast<Index>(nodes_.size());
    build(mesh, parts, rank, middle, last, most);
}

} // namespace difusa
