// The edges of a triangle soup: which triangles meet along each edge, and which fans meet at each point.
#pragma once

#include <difusa/core/types.h>

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace difusa {

/// One triangle at an edge.
struct EdgeSide {
    Index high;     ///< the edge's end point with the higher number
    Index triangle; ///< the triangle
    bool forward;   ///< true if the triangle runs from the lower end point to the higher
};

/// All edges of triangles whose corners are distinct. Built by sorting: n log n for any input.
class Edges {
  public:
    Edges(std::span<const std::array<Index, 3>> triangles, std::size_t point_count);

    /// Calls `visit(low, high, sides)` for each edge, in order of its end points low < high; `sides` are the triangles
    /// along it, in order, as std::span<const EdgeSide>.
    template <typename Visit> void for_each(Visit visit) const {
        for (std::size_t low = 0; low + 1 < first_.size(); ++low) {
            for (std::size_t i = first_[low]; i < first_[low + 1];) {
                std::size_t end = i + 1;
                while (end < first_[low + 1] && sides_[end].high == sides_[i].high) {
                    ++end;
                }
                visit(static_cast<Index>(low), sides_[i].high, std::span(sides_).subspan(i, end - i));
                i = end;
            }
        }
    }

  private:
    std::vector<EdgeSide> sides_;    ///< 3 #T, by low, then high, then triangle
    std::vector<std::size_t> first_; ///< #P + 1: the sides whose low is p are first_[p] .. first_[p+1]-1
};

/// Points around which the triangles form more than one fan (two tips that touch), in order. Triangles that share an
/// edge at the point belong to one fan, however many share it.
std::vector<Index> non_manifold_points(const Edges& edges, std::span<const std::array<Index, 3>> triangles,
                                       std::size_t point_count);

} // namespace difusa
