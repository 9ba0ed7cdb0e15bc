#include <difusa/mesh/triangle_tree.h>

namespace difusa {

BoxTree tree_of_triangles(const Mesh& mesh, const std::vector<Index>& triangles) {
    std::vector<BoxTree::Box> boxes;
    boxes.reserve(triangles.size());
    for (const Index t : triangles) {
        boxes.push_back(mesh.box(t));
    }
    return {boxes, triangles};
}

} // namespace difusa
