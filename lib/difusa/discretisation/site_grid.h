// Sites accepted so far, for samplers: is a point too close to one of them in site distance, and is a piece of surface
// wholly within reach of one?
#pragma once

#include <difusa/discretisation/cell_table.h>
#include <difusa/discretisation/site_set.h>
#include <difusa/mesh/mesh.h>

#include <array>
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
    static constexpr double cell_in_spacings = 2.0; ///< then a ball of the spacing meets at most 8 cells

    /// Calls `test(site)` for the sites of `region` in the cells within the spacing of p until it returns true; says
    /// whether it did.
    template <class Test> bool any_near(const Vec3& p, Index region, const Test& test) const;

    const Mesh& mesh_;
    double spacing_, inverse_size_;
    std::vector<SurfacePoint> sites_;
    std::vector<Index> next_; ///< #sites: the next one in the same cell
    CellTable table_;
    std::vector<Index> first_; ///< #cells: the newest site
};

} // namespace difusa
