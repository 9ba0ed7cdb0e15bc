// Sites: surface points that carry an unknown (T 4.1.1), with their radii and effective areas.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/core/types.h>
#include <difusa/discretisation/size_field.h>
#include <difusa/mesh/mesh.h>

#include <limits>
#include <span>
#include <vector>

namespace difusa {

/// The site distance of T 4.1: |p-q| / max(0, n_p·n_q); infinite if the normals are 90° or more apart (to within
/// rounding, see `perpendicular`), or if the points are on different regions. Not a metric (no triangle inequality).
inline double site_distance(const Vec3& p, const Vec3& n_p, Index region_p, const Vec3& q, const Vec3& n_q,
                            Index region_q) {
    const double cosine = n_p.dot(n_q);
    if (cosine <= perpendicular || region_p != region_q) {
        return std::numeric_limits<double>::infinity();
    }
    return (p - q).norm() / cosine;
}

struct SiteSet {
    std::vector<SurfacePoint> points; ///< #S, with shading normals
    std::vector<Index> region;        ///< #S, region of the mesh
    std::vector<double> radius;       ///< #S, r_i: site distance to the m-th nearest site (T 4.2.7)
    std::vector<double> area;         ///< #S, effective area A_i
    double spacing = 0.0;             ///< the distance enforced by the sampler, in the unit of the scene; of graded
                                      ///< sites, the one at which as many would cover the surface evenly
    int neighbours = 0;               ///< m
    bool graded = false;              ///< denser where they help
    std::vector<char> dark;           ///< empty, or #regions: 1 where no light arrives; no sites or elements there

    bool is_dark(Index of_region) const { return !dark.empty() && dark[of_region] != 0; }

    std::size_t size() const { return points.size(); }

    /// The mean over the surface, except dark regions, and over the columns, of what is known at the sites, and maybe
    /// at further points after them: at least #S by any number. By the areas of the sites.
    double mean(const Eigen::Ref<const Values>& at_points) const;
    double mean(std::span<const double> at_points) const {
        return mean(Eigen::Map<const Values>(at_points.data(), static_cast<Eigen::Index>(at_points.size()), 1));
    }
};

/// Makes a site set from sampled points, sorted along a Z curve (sites near each other in space are near in memory):
/// regions and radii; areas are those of T 5.5, pi r_i² / (m+1).
///
/// A region with too few sites for m neighbours at a finite distance has radii that cover all of it instead: its
/// diameter, which no radius exceeds. No radius is smaller than `spacing` (1 + 2^-10), or for graded sites, placed by
/// `size`, than its reach there times as much: every point that has a site as near as it should is inside a support.
/// Throws UsageError if there are no points, or if one is not where its face and coordinates on it say.
SiteSet make_site_set(const Mesh& mesh, std::vector<SurfacePoint> points, double spacing, int neighbours,
                      const Execution& execution, const SizeField* size = nullptr);

} // namespace difusa
