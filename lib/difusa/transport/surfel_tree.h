// Surfels in groups, groups in larger groups: what lets a point see a large piece of surface as one, exactly.
#pragma once

#include <difusa/core/box_tree.h>
#include <difusa/discretisation/surfels.h>
#include <difusa/rays/shaft.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace difusa {

/// Means and first moments over groups of surfels, by area. Geometry only.
class SurfelGroups {
  public:
    /// A surfel, or the union of two groups, which have smaller numbers.
    struct Group {
        Index first = none, second = none; ///< second is none: `first` is a surfel
        double area = 0.0;
        Vec3 centre = Vec3::Zero(); ///< centroid
    };

    SurfelGroups() = default;
    explicit SurfelGroups(std::vector<Group> groups, std::size_t surfels)
        : groups_(std::move(groups)), surfels_(surfels) {}

    std::size_t size() const { return groups_.size(); }
    const Group& operator[](Index g) const { return groups_[g]; }
    std::size_t bytes() const { return groups_.size() * sizeof(Group); }

    /// For each group the mean of b, in row `mean_row(g)`, and the moment 1/A ∫ b (y - centre) dA in the three rows
    /// after it, for any number of columns, from as many of the surfels (more rows are ignored), each even over its
    /// area. All rows: `moments * size()`.
    Values moments_of(const Values& of_surfels) const;
    static constexpr Index moments = 4;
    static Index mean_row(Index g) { return moments * g; }

    /// The transpose, added to the first rows of `of_surfels`; `of_groups` is used up.
    void add_transposed(Values& of_groups, Values& of_surfels) const;

  private:
    std::vector<Group> groups_;
    std::size_t surfels_ = 0;
};

/// What a point sees of a group: the light b of the group contributes ∫ K b = factor mean(b) + slope · moment(b) to its
/// irradiance, where the kernel K is linear over the group.
struct GroupFactor {
    Index group = none;
    double factor = 0.0;       ///< the form factor, ∫ K
    Vec3 slope = Vec3::Zero(); ///< A ∇K

    bool operator<(const GroupFactor& other) const { return group < other.group; }
};

/// A binary tree over the surfels of each region: within a triangle, then within a plane, then within the region, then
/// over all of them. A **patch** is a group whose shape is known: a convex polygon in a plane, or any number of whole
/// triangles, of which the edges of the outline are known.
class SurfelTree {
  public:
    enum class Shape {
        polygon, ///< corners counterclockwise
        outline, ///< directed edges of whole triangles
        bundle   ///< of groups that no outline describes, or of surfels that are not in one plane
    };
    struct Edge {
        Index from = none, to = none; ///< points of the mesh, counterclockwise around what is within
        Index triangle = none;        ///< it is a side of
    };
    struct Node {
        Shape shape = Shape::bundle;
        bool flat = false;                  ///< in the plane of `normal` and `offset`
        Exposure exposure = Exposure::both; ///< of all its faces; both: they differ
        Vec3 normal = Vec3::Zero();         ///< flat: unit
        double offset = 0.0;                ///< flat: of the plane
        Index begin = 0, end = 0;           ///< of its corners or edges
        BoxTree::Box box;
    };

    /// `exposures`, `overlaid`: of the mesh (rays/shaft.h). Surfels of faces that are overlaid are in no group.
    SurfelTree(const Mesh& mesh, const Surfels& surfels, const std::vector<Exposure>& exposures,
               const std::vector<std::uint8_t>& overlaid);

    /// The last group is the root, if there is one.
    const SurfelGroups& groups() const { return groups_; }
    const Node& node(Index g) const { return nodes_[g]; }
    std::span<const Vec3> corners(const Node& node) const {
        return std::span(corners_).subspan(node.begin, node.end - node.begin);
    }
    std::span<const Edge> edges(const Node& node) const {
        return std::span(edges_).subspan(node.begin, node.end - node.begin);
    }

  private:
    friend class SurfelTreeBuilder;
    SurfelGroups groups_;
    std::vector<Node> nodes_; ///< #groups
    std::vector<Vec3> corners_;
    std::vector<Edge> edges_;
};

} // namespace difusa
