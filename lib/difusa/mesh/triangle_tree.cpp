#include <difusa/mesh/triangle_tree.h>

#include <utility>

namespace difusa {

BoxTree tree_of_triangles(const Mesh& mesh, std::vector<Index> triangles) {
    std::vector<BoxTree::Box> boxes;
    boxes.reserve(triangles.size());
    for (const Index t : triangles) {
        boxes.push_back(mesh.box(t));
    }
    return {std::move(boxes), std::move(triangles)};
}

} // namespace difusa
