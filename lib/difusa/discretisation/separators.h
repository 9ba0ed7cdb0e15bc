// What parts a region without cutting its triangles: a wall that stands on a floor which runs on beneath it, the foot
// of a table, a board stuck through a panel. Elements do not reach through it.
#pragma once

#include <difusa/core/box_tree.h>
#include <difusa/discretisation/obstacles.h>
#include <difusa/discretisation/region_trees.h>
#include <difusa/discretisation/site_set.h>
#include <difusa/mesh/mesh.h>

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

namespace difusa {

/// A triangle that parts a region.
using Separator = RegionTriangle;

/// How far from a plane coordinates count as lying in it: what single precision can tell.
double wall_rounding(const Mesh& mesh);

/// All separators, by region, then by triangle.
///
/// A triangle is a **separator** of another region if it touches triangles of the region that lie on both sides of its
/// plane: one that does, or several. Walls around a convex floor have it on one side only; what lies in one plane with
/// the region parts nothing. Triangles touch, and lie on a plane, as far as coordinates in single precision can tell
/// (2^-21 of the mesh' diameter): a separator too many costs time, for `Separators::hides` asks for a proper crossing.
std::vector<Separator> find_separators(const Mesh& mesh);
std::vector<Separator> find_separators(const Mesh& mesh, const RegionTrees& trees, const Execution& execution);

/// Which sites are out of sight of a point of their own region.
class Separators {
  public:
    /// The air before a point, along its normal.
    struct Clearance {
        double searched = 0.0;                                  ///< how far obstacles were looked for
        double first = std::numeric_limits<double>::infinity(); ///< the nearest that was found
    };

    /// A point seen from many sites: what is found out about it for one serves the next. The point must outlive it.
    class Viewpoint {
      public:
        explicit Viewpoint(const SurfacePoint& x) : x_(x) {}

      private:
        friend class Separators;
        const SurfacePoint& x_;
        Clearance clearance_;
        BoxTree::Box around_;                ///< where other regions were looked for
        std::vector<const BoxTree*> others_; ///< their triangles
        Index last_ = none;                  ///< what a line of sight was found to cross last: tried first
    };

    Separators() = default;

    /// `support`: #S, the Euclidean radii of the elements. The mesh must outlive this; the sites too.
    Separators(const Mesh& mesh, const SiteSet& sites, std::span<const double> support,
               const Execution& execution = {});

    /// True if some region has anything that may hide its points from each other.
    bool any() const { return any_; }

    /// True if the region has.
    bool any(Index region) const { return any() && sight_[region].obstructed; }

    /// True if something may hide a point of the site's support from it: else nothing does.
    bool near(Index site) const { return near_[site] != 0; }

    /// True if there is no line of sight from the site to x, a point of its region, both lifted off the surface: it
    /// crosses a separator of the region, or every such line crosses an obstacle (obstacles.h), which may be the region
    /// itself. What only touches a line or lies in its plane, such as x at the foot of a wall, does not cross it. A
    /// line of sight proves that light can get from the air before the one point to that before the other.
    ///
    /// Points are lifted along their normals by 2^-6 of the site's support, if that is not enough by four times and 16
    /// times as much, and by half of how far the other point lies below their tangent plane, so that lines stay above a
    /// surface that bulges; by half of the air before them if something is in the way.
    ///
    /// In a low gap, as between a lamp and the ceiling that it hangs from, there is light only close to its edges. If
    /// there is less air before one of the two points than 1/48 of the largest support of the region, and less than a
    /// quarter as much as before the other, one line of sight decides: the one between ends lifted by a quarter of the
    /// site's support, or by half of their air. Larger gaps, and all of them where sites are dense, are treated like
    /// the open surface: elements that reach a little into them cost less than none that does.
    bool hides(Index site, Viewpoint& x) const;
    bool hides(Index site, const SurfacePoint& x) const;

  private:
    /// What a region has.
    struct Sight {
        bool obstructed = false;  ///< by walls, obstacles or itself
        bool by_itself = false;   ///< its own triangles are looked at, too
        std::vector<Index> walls; ///< its separators, ascending
        BoxTree tree;             ///< of the walls
        double reach = 0.0;       ///< the largest support
    };
    void find_near(const std::vector<Index>& planes, const std::vector<char>& simple, const Execution& execution);
    std::span<const BoxTree* const> others(Index region, Viewpoint& x, const BoxTree::Box& box) const;
    template <class Meets, class Act>
    bool visit_obstacles(Index region, std::span<const BoxTree* const> others, const Meets& meets,
                         const Act& act) const;
    bool blocks(Index triangle, Index region) const;
    void find_clearances(const Execution& execution);
    Clearance clearance(Index region, Viewpoint& viewpoint, double range) const;
    double lift(Index site, double wanted) const;
    double lift(Index region, Viewpoint& x, double wanted) const;
    bool crosses(Index triangle, const Vec3& a, const Vec3& b) const;
    bool crosses_wall(Index region, const Vec3& a, const Vec3& b) const;
    bool crosses_obstacle(Index region, std::span<const BoxTree* const> others, const Vec3& a, const Vec3& b,
                          Index& last) const;

    const Mesh* mesh_ = nullptr;
    const SiteSet* sites_ = nullptr;
    std::vector<double> support_;                ///< #S, at most the extent of the site's region
    std::vector<std::uint8_t> near_;             ///< #S
    std::vector<Clearance> clearance_;           ///< #S, of those that are near something
    std::shared_ptr<const Obstacles> obstacles_; ///< of other regions
    std::vector<Sight> sight_;                   ///< #regions
    bool any_ = false;
    double rounding_ = 0.0; ///< of coordinates
};

} // namespace difusa
