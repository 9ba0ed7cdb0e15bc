// Sites accepted so far, for samplers: is a point too close to one of them in site distance, and is a piece of surface
// entirely within reach of one?
#pragma once

#include <difusa/core/progress.h>
#include <difusa/discretisation/site_set.h>
#include <difusa/discretisation/spatial_hash.h>
#include <difusa/mesh/mesh.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace difusa {

/// A candidate for a site.
struct Dart {
    SurfacePoint place;
    std::uint64_t priority; ///< lowest first; of equal ones the first in the list
};

/// The distance between two coordinates next to each other, where it is largest on the mesh.
double coordinate_step(const Mesh& mesh);

class SiteGrid {
  public:
    /// Holds up to `limit` sites. The mesh must outlive the grid. Throws ResourceError for a spacing too small for the
    /// grid, InputError for one of a few coordinate steps only.
    SiteGrid(const Mesh& mesh, double spacing, std::size_t limit);

    /// True if a site is closer to x than the spacing, in site distance.
    bool conflicts(const SurfacePoint& x) const;

    /// True if one site reaches every point of the triangle `corners`, part of the mesh's triangle `face`, within the
    /// spacing (in site distance: the normal is constant over it, so the farthest point is a corner).
    bool covers(Index face, const std::array<Vec3, 3>& corners) const;

    /// Turns darts into sites: exactly those that, taken one at a time by priority, conflict with no earlier site.
    /// Throws ResourceError if there are then more sites than the limit.
    void insert(std::span<const Dart> darts, const Execution& execution);

    const std::vector<SurfacePoint>& sites() const { return sites_; }
    std::vector<SurfacePoint> take() { return std::move(sites_); }

  private:
    bool too_close(const SurfacePoint& x, Index region, const SpatialHash::Item& other) const;

    // Steps for the darts with the given numbers: a hash of them; those without conflict with any site; those of these
    // that become sites, if within the limit; and adding them as sites.
    SpatialHash hash_of(std::span<const Dart> darts, std::span<const Index> of, const Execution& execution) const;
    void append(std::span<const Dart> darts, std::span<const Index> of, SpatialHash& hash,
                const Execution& execution) const;
    std::vector<Index> without_conflict(std::span<const Dart> darts, std::vector<Index> of,
                                        const Execution& execution) const;
    std::vector<Index> first_come(std::span<const Dart> darts, std::span<const Index> of, const SpatialHash& hash,
                                  const Execution& execution) const;
    void accept(std::span<const Dart> darts, std::span<const Index> of, const Execution& execution);

    const Mesh& mesh_;
    double spacing_;
    std::size_t limit_;
    std::vector<SurfacePoint> sites_;
    SpatialHash hash_; ///< of the sites
};

} // namespace difusa
