// The triangles of each region, found by overlap with a box.
#pragma once

#include <difusa/core/box_tree.h>
#include <difusa/mesh/mesh.h>

#include <span>
#include <vector>

namespace difusa {

/// The trees of single regions are made when they are first asked for: not thread-safe.
class RegionTrees {
  public:
    /// The mesh must outlive this.
    explicit RegionTrees(const Mesh& mesh);

    /// Boxes of whole regions.
    const BoxTree& regions() const { return regions_; }

    /// The triangles of a region, ascending.
    std::span<const Index> members(Index region) const {
        return std::span(members_).subspan(first_[region], first_[region + std::size_t{1}] - first_[region]);
    }

    /// Their boxes.
    const BoxTree& triangles(Index region);

  private:
    const Mesh& mesh_;
    std::vector<std::size_t> first_; ///< #regions + 1
    std::vector<Index> members_;     ///< #T, by region
    BoxTree regions_;
    std::vector<BoxTree> trees_; ///< #regions
};

} // namespace difusa
