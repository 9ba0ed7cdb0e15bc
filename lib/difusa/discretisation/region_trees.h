// The triangles of each region, found by overlap with a box.
#pragma once

#include <difusa/core/box_tree.h>
#include <difusa/core/progress.h>
#include <difusa/mesh/mesh.h>

#include <functional>
#include <mutex>
#include <span>
#include <vector>

namespace difusa {

/// The box of all points at most `by` from `box` along each axis.
inline BoxTree::Box grown(const BoxTree::Box& box, double by) {
    return {box.min() - Vec3::Constant(by), box.max() + Vec3::Constant(by)};
}

/// The box of each region of a mesh.
std::vector<BoxTree::Box> region_boxes(const Mesh& mesh);

/// The trees of single regions are made when they are first asked for.
class RegionTrees {
  public:
    /// The mesh must outlive this.
    explicit RegionTrees(const Mesh& mesh);

    /// Boxes of whole regions.
    const BoxTree& regions() const { return regions_; }

    const BoxTree::Box& box(Index region) const { return boxes_[region]; }

    /// The triangles of a region, ascending.
    std::span<const Index> members(Index region) const {
        return std::span(members_).subspan(first_[region], first_[region + std::size_t{1}] - first_[region]);
    }

    /// Their boxes. Thread-safe.
    const BoxTree& triangles(Index region) const;

  private:
    const Mesh& mesh_;
    std::vector<std::size_t> first_;  ///< #regions + 1
    std::vector<Index> members_;      ///< #T, by region
    std::vector<BoxTree::Box> boxes_; ///< #regions
    BoxTree regions_;
    struct Tree {
        std::once_flag made;
        BoxTree tree;
    };
    mutable std::vector<Tree> trees_; ///< #regions
};

/// A triangle, and a region that it does something to.
struct RegionTriangle {
    Index region = none;
    Index triangle = none;
    friend bool operator==(const RegionTriangle&, const RegionTriangle&) = default;
};

/// All pairs for which `list(triangle, regions)`, which is called by several threads, appends the region to the empty
/// list `regions`; by triangle.
std::vector<RegionTriangle>
regions_by_triangle(const Mesh& mesh, const std::function<void(Index triangle, std::vector<Index>& regions)>& list,
                    const Execution& execution);

} // namespace difusa
