// What may come between two points of a region: what stands on it, hangs just above it, or the region itself where it
// is folded.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/discretisation/region_trees.h>
#include <difusa/mesh/mesh.h>

#include <span>
#include <vector>

namespace difusa {

/// True for each region whose triangles lie in one plane, up to `rounding`.
std::vector<char> flat_regions(const Mesh& mesh, const RegionTrees& trees, double rounding);

/// True for each region that has no border: what is before it is connected, and folds of such bodies are let pass.
std::vector<char> closed_regions(const Mesh& mesh);

/// How far lines of sight between points of a region leave it.
struct SightReach {
    double around = 0.0; ///< from the nearest of its triangles; 0: no lines of sight
    double lift = 0.0;   ///< along the normals of their ends
    bool flat = false;   ///< all of the region lies in one plane
};

/// For each region, the triangles of other regions that lines of sight between two of its points may cross, ascending:
/// those within reach, and within the box of the region grown by the lift, that have points of the region, or of what
/// is lifted off it, on both sides of their planes.
/// Walls around a convex floor are not among them. Of a bent region, points as far away as the lift in any direction
/// count. `reach`: #regions.
std::vector<std::vector<Index>> find_obstacles(const Mesh& mesh, const RegionTrees& trees,
                                               std::span<const SightReach> reach, double rounding,
                                               const Execution& execution = {});

/// True if the triangles of the region of p within `radius` of it are all joined to that of p, through triangles
/// within the radius, and face the way of p: between points as close as that the region itself does not come.
class FoldSearch {
  public:
    /// Both must outlive this.
    FoldSearch(const Mesh& mesh, const RegionTrees& trees)
        : mesh_(mesh), trees_(trees), seen_(mesh.triangles.size(), 0) {}

    bool unfolded(const SurfacePoint& p, double radius);

  private:
    const Mesh& mesh_;
    const RegionTrees& trees_;
    std::vector<std::uint32_t> seen_; ///< #T, number of the search that met it
    std::uint32_t search_ = 0;
    std::vector<Index> open_;
};

} // namespace difusa
