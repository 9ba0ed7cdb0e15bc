#include <difusa/mesh/triangle_tree.h>

#include <numeric>

namespace difusa {

BoxTree tree_of_triangles(const Mesh& mesh, const std::vector<Index>& triangles) {
    std::vector<BoxTree::Box> boxes;
    boxes.reserve(triangles.size());
    for (const Index t : triangles) {
        boxes.push_back(mesh.box(t));
    }
    return {boxes, triangles};
}

BoxTree tree_of_triangles(const Mesh& mesh) {
    std::vector<Index> all(mesh.triangles.size());
    std::iota(all.begin(), all.end(), Index{0});
    return tree_of_triangles(mesh, all);
}

} // namespace difusa
