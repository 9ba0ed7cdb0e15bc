// Which supports hold a given surface point? Asked once for every ray of a bake, so it has to be cheap.
#pragma once

#include <difusa/scene/mesh.h>
#include <difusa/sites/site_set.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace difusa {

/// A grid over the surface. Each cell that some piece of a patch passes through lists the sites of that patch
/// whose support reaches into the cell. A support is a ball of Euclidean radius `support[i]` around site i, cut
/// by "normals agree" and "same patch"; site distance is never below the Euclidean one, so a support in site
/// distance lies inside.
class SupportGrid {
  public:
    /// What a candidate's test needs, in one cache line.
    struct Candidate {
        std::array<double, 3> position;
        std::array<double, 3> normal;
        double support_squared;
        Index site;
    };

    SupportGrid() = default;

    /// `support`: #S. The mesh may be forgotten afterwards.
    SupportGrid(const Mesh& mesh, const SiteSet& sites, std::span<const double> support);

    /// The candidates whose support may hold a point of `patch` at `position`, by site number; the caller tests
    /// them. Empty if none does, or the point is not on the mesh.
    std::span<const Index> near(const Vec3& position, Index patch) const {
        const std::size_t slot = find(cell_of(position), patch);
        return slot == empty ? std::span<const Index>() : span_of(slot);
    }

    const Candidate& candidate(Index site) const { return candidates_[site]; }

  private:
    using Cell = std::array<std::int32_t, 3>;
    struct Slot {
        Cell cell;
        Index patch = none;
        Index bucket = none;
    };
    static constexpr std::size_t empty = static_cast<std::size_t>(-1);

    Cell cell_of(const Vec3& position) const;
    std::size_t find(const Cell& cell, Index patch) const;
    void insert(const Cell& cell, Index patch);
    void grow();
    void mark(const Mesh& mesh);
    std::span<const Index> span_of(std::size_t slot) const {
        const Index bucket = slots_[slot].bucket;
        return {entries_.data() + first_[bucket], first_[bucket + 1] - first_[bucket]};
    }

    Vec3 origin_ = Vec3::Zero();
    double inverse_size_ = 1.0;
    std::vector<Candidate> candidates_; ///< #S
    std::vector<Slot> slots_;           ///< open addressing, a power of two, at most half full
    std::size_t bucket_count_ = 0;
    std::vector<std::size_t> first_; ///< #buckets + 1
    std::vector<Index> entries_;
};

} // namespace difusa
