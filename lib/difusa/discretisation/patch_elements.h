// Elements of the classical method that are finer than its patches (L 31): triangles into which patches are quartered.
#pragma once

#include <difusa/discretisation/patch_mesh.h>

#include <array>
#include <span>
#include <vector>

namespace difusa {

/// A tree over each patch of a mesh: its root is the patch, and what is not quartered is an element. The four quarters
/// have half the edges: one at each corner, and one between the midpoints of the edges.
class PatchElements {
  public:
    static constexpr int most_levels = 8; ///< quarterings in a row

    /// Even sites are at the centres of patches; graded ones at those of elements of patches with edges so many times
    /// as long. Halving edges twice as long gives a quarter of the patches.
    static constexpr double coarseness = 2.0;

    /// Each patch is an element, without a site. `patches` must outlive this.
    explicit PatchElements(const PatchMesh& patches);

    /// The elements at whose centres these sites are, numbered by them: what has more than one of them is quartered.
    /// Some elements may have no site. Throws UsageError, with what is wrong, if there is no such division.
    PatchElements(const PatchMesh& patches, std::span<const SurfacePoint> sites);

    /// Nodes of the trees; those that are elements, of a patch in a row, patches in their order.
    std::vector<Index> elements() const;
    std::size_t element_count() const { return elements_; }

    /// The element at a place.
    Index at(const PatchMesh::Place& place) const;

    Index patch(Index node) const { return nodes_[node].patch; }
    int level(Index node) const { return nodes_[node].level; }
    double area(Index node) const;
    SurfacePoint centre(Index node) const;
    std::array<Vec3, 3> corners(Index node) const;

    /// The site of an element, or none.
    Index site(Index node) const { return nodes_[node].site; }

    /// Quarters an element; returns the first of its quarters, which are numbered in a row.
    Index quarter(Index node);

  private:
    using Weights = std::array<double, 3>; ///< barycentric
    struct Node {
        Index patch = none, first = none, site = none; ///< `first` of the quarters; none: an element
        int level = 0;
        std::array<Weights, 3> corner{}; ///< in the patch; multiples of 2^-level
    };
    /// The quarter of a node that holds a place; `w`, the coordinates there in the node, become those in the quarter.
    static Index quarter_at(const Node& node, Weights& w);

    const PatchMesh* patches_;
    std::vector<Node> nodes_; ///< the patches first
    std::size_t elements_ = 0;
};

} // namespace difusa
