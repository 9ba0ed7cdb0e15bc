// Which supports hold a given surface point? Asked once for every ray of a bake, so it has to be cheap.
#pragma once

#include <difusa/discretisation/cell_table.h>
#include <difusa/discretisation/site_set.h>
#include <difusa/mesh/mesh.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace difusa {

/// A grid over the surface. Each cell that some piece of a region passes through lists the sites of that region
/// whose support reaches into the cell. A support is a ball of Euclidean radius `support[i]` around site i, cut
/// by "normals agree" and "same region"; site distance is never below the Euclidean one, so a support in site
/// distance lies inside.
class SupportGrid {
  public:
    /// What a candidate's test and weight need, in one cache line.
    struct alignas(64) Candidate {
        std::array<double, 3> position;
        std::array<double, 3> normal;
        double support_squared;
        double radius;
    };

    SupportGrid() = default;

    /// `support`: #S. The mesh may be forgotten afterwards.
    SupportGrid(const Mesh& mesh, const SiteSet& sites, std::span<const double> support);

    /// The sites whose support may hold a point of `region` at `position`, ascending; the caller tests their
    /// candidates. Empty if there is none, or the point is not on the mesh.
    std::span<const Index> near(const Vec3& position, Index region) const {
        return span_of(table_.find(cell_of(position), region));
    }

    /// A point and its region, and where its search stands.
    struct Query {
        const Vec3* position;
        Index region;
        std::span<const Index> near;
    };

    /// `near` for many points at once. Their memory is fetched while others are searched for: several times as fast
    /// where points are far apart.
    void near(std::span<Query> queries) const;

    const Candidate& candidate(Index site) const { return candidates_[site]; }

  private:
    Cell cell_of(const Vec3& position) const {
        const Vec3 scaled = (position - origin_) * inverse_size_;
        // Positions lie in the bounding box up to rounding; +1 makes truncation a floor down to -1.
        return {static_cast<std::int32_t>(scaled[0] + 1.0) - 1, static_cast<std::int32_t>(scaled[1] + 1.0) - 1,
                static_cast<std::int32_t>(scaled[2] + 1.0) - 1};
    }
    void mark(const Mesh& mesh);
    std::span<const Index> span_of(Index bucket) const {
        return bucket == none
                   ? std::span<const Index>()
                   : std::span<const Index>(entries_.data() + first_[bucket], first_[bucket + 1] - first_[bucket]);
    }

    Vec3 origin_ = Vec3::Zero();
    double inverse_size_ = 1.0;
    std::vector<Candidate> candidates_; ///< #S
    CellTable table_;                   ///< bucket of each cell that the surface passes through
    std::vector<std::size_t> first_;    ///< #buckets + 1
    std::vector<Index> entries_;
};

} // namespace difusa
