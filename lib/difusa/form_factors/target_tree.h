// Triangles in a tree of boxes, so that groups of them are found to be out of view together.
#pragma once

#include <difusa/core/types.h>
#include <difusa/mesh/mesh.h>
#include <difusa/rays/flat_polygon.h>

#include <array>
#include <vector>

namespace difusa {

/// A binary tree over the triangles of a mesh. Near its root triangles are divided by flat parts, below by place, so
/// that most nodes are flat.
class TargetTree {
  public:
    struct Node {
        std::array<Vec3, 8> corner; ///< of the bounding box
        Plane plane;                ///< of all its triangles, if `flat`
        bool flat = false;
        Index first = 0, last = 0; ///< its triangles are order()[first] to order()[last - 1]
        Index right = none;        ///< none: a leaf; otherwise the left child follows the node
        Index highest = 0;         ///< the largest rank among its triangles
    };

    static constexpr Index root = 0;

    /// `parts`: flat_parts(mesh). `rank`: a number for each triangle, by which a search can leave out nodes. `most`:
    /// triangles in a leaf.
    TargetTree(const Mesh& mesh, const std::vector<Index>& parts, const std::vector<Index>& rank, Index most = 8);

    std::size_t size() const { return nodes_.size(); }

    const Node& node(Index number) const { return nodes_[number]; }
    const std::vector<Index>& order() const { return order_; }

  private:
    void build(const Mesh& mesh, const std::vector<Index>& parts, const std::vector<Index>& rank, Index first,
               Index last, Index most);

    std::vector<Node> nodes_;
    std::vector<Index> order_;
};

} // namespace difusa
