// What may come between two points of a region: what stands on it, hangs just above it, or the region itself where it
// is folded.
#pragma once

#include <difusa/discretisation/region_trees.h>
#include <difusa/mesh/mesh.h>

#include <memory>
#include <vector>

namespace difusa {

/// The largest triangle of each region whose triangles all lie in the plane of that one, up to `rounding`; else `none`.
std::vector<Index> planes_of_regions(const Mesh& mesh, const RegionTrees& trees, double rounding);

/// True for each region that has no border: what is before it is connected, and folds of such bodies are let pass.
std::vector<char> closed_regions(const Mesh& mesh);

/// How far lines of sight between points of a region leave it.
struct SightReach {
    double around = 0.0; ///< from the nearest of its triangles; 0: no lines of sight
    double lift = 0.0;   ///< along the normals of their ends
    Index plane = none;  ///< a triangle in whose plane all of the region lies, if there is one
};

/// The triangles that lines of sight between two points of one region may cross. They are looked for where they are
/// asked about, in the trees of all regions, because listing them for each region takes much longer where many regions
/// penetrate each other.
class Obstacles {
  public:
    /// `reach`: #regions. The mesh must outlive this.
    Obstacles(const Mesh& mesh, std::shared_ptr<const RegionTrees> trees, std::vector<SightReach> reach,
              double rounding);

    /// True if triangle F, of another region, is within reach of this one, within the box of the region grown by the
    /// lift and, if the region is flat, between its plane and that of what is lifted off it, and has points of the
    /// region, or of what is lifted off it, on both sides of its plane. Walls around a convex floor have not. Of a bent
    /// region, points as far away as the lift in any direction count.
    bool may_obstruct(Index F, Index region) const;

    /// True if any triangle may.
    bool any(Index region) const;

    /// Calls `act(T)` for the triangles of all regions but one whose boxes meet(box) says yes to, until it returns
    /// true. True if it did. `meets` must be true of every box that contains such a box.
    template <class Meets, class Act> bool visit_others(Index but, const Meets& meets, const Act& act) const {
        return trees_->regions().visit_where(
            meets, [&](Index region) { return region != but && trees_->triangles(region).visit_where(meets, act); });
    }

    const RegionTrees& trees() const { return *trees_; }

  private:
    const Mesh& mesh_;
    std::shared_ptr<const RegionTrees> trees_;
    std::vector<SightReach> reach_;
    double rounding_;
};

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
