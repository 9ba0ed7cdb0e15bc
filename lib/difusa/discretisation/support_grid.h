// Which supports contain a given surface point? Queried once for every ray of a bake, so it has to be fast.
#pragma once

#include <difusa/discretisation/cell_table.h>
#include <difusa/discretisation/site_set.h>
#include <difusa/mesh/mesh.h>

#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

namespace difusa {

/// A grid over each region of the surface. Each cell that some piece of the region passes through lists the sites of
/// that region whose support reaches into the cell. A support is a ball of Euclidean radius `support[i]` around site i,
/// restricted by "normals agree" and "same region"; site distance is never below the Euclidean distance, so a support
/// in site distance lies inside.
class SupportGrid {
  public:
    /// The data for a candidate's test and weight, in one cache line.
    struct alignas(64) Candidate {
        std::array<double, 3> position;
        std::array<double, 3> normal;
        double support_squared;
        double radius;
    };

    SupportGrid() = default;

    /// `support`: #S. The mesh is not needed afterwards. Throws UsageError unless all supports are finite and above 0.
    SupportGrid(const Mesh& mesh, const SiteSet& sites, std::span<const double> support);

    /// The sites whose support may contain a point of `region` at `position`, ascending; the caller tests the
    /// candidates. Empty if there are none, or the point is not on the mesh.
    std::span<const Index> near(const Vec3& position, Index region) const {
        const Cell cell = cell_of(position, region);
        return span_of(bucket_of(blocks_.find(block_of(cell), region), cell));
    }

    /// A point and its region, and the state of its search.
    struct Query {
        const Vec3* position;
        Index region;
        std::span<const Index> near;
    };

    /// `near` for many points at once. Memory is prefetched for some while others are searched: several times as fast
    /// for points that are far apart.
    void near(std::span<Query> queries) const;

    /// Of a cell and a site whose support reaches into it.
    std::size_t pair_count() const { return entries_.size(); }

    const Candidate& candidate(Index site) const { return candidates_[site]; }

  private:
    Cell cell_of(const Vec3& position, Index region) const {
        const Vec3 scaled = (position - origin_) * inverse_size_[region];
        // Positions lie in the bounding box up to rounding; +1 makes truncation a floor down to -1.
        return {static_cast<std::int32_t>(scaled[0] + 1.0) - 1, static_cast<std::int32_t>(scaled[1] + 1.0) - 1,
                static_cast<std::int32_t>(scaled[2] + 1.0) - 1};
    }
    // Cells are stored in blocks of 4 along each axis: the table of blocks is small, and one lookup finds 64 cells.
    static Cell block_of(const Cell& cell) { return {cell[0] >> 2, cell[1] >> 2, cell[2] >> 2}; }
    static unsigned bit_of(const Cell& cell) {
        return static_cast<unsigned>((cell[0] & 3) | ((cell[1] & 3) << 2) | ((cell[2] & 3) << 4));
    }
    struct Occupied {
        std::uint64_t cells = 0; ///< one bit per cell, set if the surface passes through it
        Index first = 0;         ///< bucket of the first of them; the others follow
    };
    /// For a cell in the block with this number; both may be none.
    Index bucket_of(Index block, const Cell& cell) const {
        if (block == none) {
            return none;
        }
        const Occupied& occupied = occupied_[block];
        const std::uint64_t bit = std::uint64_t{1} << bit_of(cell);
        const std::uint64_t before = occupied.cells & (bit - 1);
        return (occupied.cells & bit) == 0 ? none : occupied.first + static_cast<Index>(std::popcount(before));
    }
    void choose_sizes(const Mesh& mesh, const SiteSet& sites, std::span<const double> support);
    void mark(const Mesh& mesh);
    template <class Act>
    void for_each_cell(const Cell& block, Index number, const Vec3& centre, double reach, const Act& act) const;
    template <class Act> void for_each_cell(const Vec3& centre, Index region, double reach, const Act& act) const;
    std::span<const Index> span_of(Index bucket) const {
        return bucket == none
                   ? std::span<const Index>()
                   : std::span<const Index>(entries_.data() + first_[bucket], first_[bucket + 1] - first_[bucket]);
    }

    Vec3 origin_ = Vec3::Zero();
    std::vector<double> inverse_size_;  ///< #regions: of the cells; 0 where there is no site
    std::vector<Candidate> candidates_; ///< #S
    CellTable blocks_;                  ///< numbers the blocks that the surface passes through, of each region
    std::vector<Occupied> occupied_;    ///< #blocks
    std::vector<std::size_t> first_;    ///< #buckets + 1
    std::vector<Index> entries_;
};

} // namespace difusa
