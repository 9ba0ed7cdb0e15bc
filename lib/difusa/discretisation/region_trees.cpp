#include <difusa/discretisation/region_trees.h>

#include <difusa/mesh/triangle_tree.h>

#include <utility>

namespace difusa {

RegionTrees::RegionTrees(const Mesh& mesh) : mesh_(mesh), trees_(mesh.region_count) {
    std::vector<BoxTree::Box> boxes(mesh.region_count);
    first_.assign(mesh.region_count + std::size_t{1}, 0);
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        boxes[mesh.region[t]].extend(mesh.box(t));
        ++first_[mesh.region[t] + std::size_t{1}];
    }
    for (std::size_t p = 0; p < mesh.region_count; ++p) {
        first_[p + 1] += first_[p];
    }
    members_.resize(mesh.triangles.size());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        members_[next[mesh.region[t]]++] = t;
    }
    std::vector<Index> numbers(mesh.region_count);
    for (Index p = 0; p < mesh.region_count; ++p) {
        numbers[p] = p;
    }
    regions_ = BoxTree(std::move(boxes), std::move(numbers));
}

const BoxTree& RegionTrees::triangles(Index region) {
    if (trees_[region].empty()) {
        const std::span<const Index> own = members(region);
        trees_[region] = tree_of_triangles(mesh_, {own.begin(), own.end()});
    }
    return trees_[region];
}

} // namespace difusa
