#include <difusa/discretisation/region_trees.h>

#include <difusa/core/parallel.h>
#include <difusa/mesh/triangle_tree.h>

namespace difusa {

std::vector<BoxTree::Box> region_boxes(const Mesh& mesh) {
    std::vector<BoxTree::Box> boxes(mesh.region_count);
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        boxes[mesh.region[t]].extend(mesh.box(t));
    }
    return boxes;
}

RegionTrees::RegionTrees(const Mesh& mesh) : mesh_(mesh), boxes_(region_boxes(mesh)), trees_(mesh.region_count) {
    first_.assign(mesh.region_count + std::size_t{1}, 0);
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
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
    regions_ = BoxTree(boxes_, numbers);
}

const BoxTree& RegionTrees::triangles(Index region) const {
    Tree& tree = trees_[region];
    std::call_once(tree.made, [&] {
        const std::span<const Index> own = members(region);
        tree.tree = tree_of_triangles(mesh_, {own.begin(), own.end()});
    });
    return tree.tree;
}

std::vector<RegionTriangle>
regions_by_triangle(const Mesh& mesh, const std::function<void(Index triangle, std::vector<Index>& regions)>& list,
                    const Execution& execution) {
    constexpr std::size_t grain = 1024;
    std::vector<std::vector<RegionTriangle>> parts((mesh.triangles.size() + grain - 1) / grain);
    parallel_for(mesh.triangles.size(), grain, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        std::vector<Index> regions;
        for (std::size_t triangle = begin; triangle < end; ++triangle) {
            regions.clear();
            list(static_cast<Index>(triangle), regions);
            for (const Index region : regions) {
                parts[begin / grain].push_back({region, static_cast<Index>(triangle)});
            }
        }
    });
    std::vector<RegionTriangle> all;
    for (const std::vector<RegionTriangle>& part : parts) {
        all.insert(all.end(), part.begin(), part.end());
    }
    return all;
}

} // namespace difusa
