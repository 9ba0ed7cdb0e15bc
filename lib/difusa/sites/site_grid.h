// Sites accepted so far, for samplers: is a point too close to one of them in site distance, and is a piece of surface
// wholly within reach of one?
#pragma once

#include <difusa/scene/mesh.h>
#include <difusa/sites/site_set.h>

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace difusa {

class SiteGrid {
  public:
    /// The mesh must outlive the grid.
    SiteGrid(const Mesh& mesh, double spacing);

    /// True if a site lies closer to x than the spacing, in site distance.
    bool conflicts(const SurfacePoint& x) const;

    /// True if one site reaches every point of the triangle `corners`, a part of the mesh's triangle `face`, within
    /// the spacing (in site distance: the normal is the same all over it, so the farthest point is a corner).
    bool covers(Index face, const std::array<Vec3, 3>& corners) const;

    void insert(const SurfacePoint& x);

    const std::vector<SurfacePoint>& sites() const { return sites_; }
    std::vector<SurfacePoint> take() { return std::move(sites_); }

  private:
    struct Cell {
        std::int64_t x, y, z;
        bool operator==(const Cell&) const = default;
    };
    struct Hash {
        std::size_t operator()(const Cell& cell) const;
    };
    Cell cell_of(const Vec3& p) const;

    /// Calls `test(site)` for the sites in the 27 cells around p until it returns true; says whether it did.
    template <class Test> bool any_near(const Vec3& p, const Test& test) const;

    const Mesh& mesh_;
    double spacing_;
    std::vector<SurfacePoint> sites_;
    std::vector<Index> next_; ///< #sites: the next one in the same cell
    std::unordered_map<Cell, Index, Hash> first_;
};

} // namespace difusa
