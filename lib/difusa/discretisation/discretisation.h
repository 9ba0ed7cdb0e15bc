// Everything between the surface and the linear system: sites, basis, surfels, and where light is gathered.
#pragma once

#include <difusa/discretisation/basis.h>
#include <difusa/discretisation/basis_averages.h>
#include <difusa/discretisation/projection.h>
#include <difusa/discretisation/site_set.h>
#include <difusa/discretisation/surfels.h>

#include <memory>
#include <vector>

namespace difusa {

/// Depends on geometry alone; shared, and immutable once made.
struct Discretisation {
    std::shared_ptr<const SiteSet> sites;
    std::shared_ptr<const Basis> basis; ///< bound to the sites
    std::shared_ptr<const Surfels> surfels;
    std::shared_ptr<const BasisAverages> averages; ///< P: coefficients to means over the surfels
    std::vector<double> integrals;                 ///< #S: A_i = ∫ phi_i dA (T 5.3)
    double uncovered = 0.0;           ///< area of the surfels not covered by any basis function, except on dark regions
    std::vector<SurfacePoint> points; ///< where light is gathered; the sites first
    std::shared_ptr<const Projection> projection; ///< irradiance at the points to coefficients, in the equation
    std::shared_ptr<const Projection> evaluation; ///< likewise, for the field that is evaluated

    /// The side of surfels for sites at a spacing: this gives about six per site.
    static double surfel_edge(double spacing) { return 0.5 * spacing; }
};

/// A_i = ∫ phi_i dA, as sums over surfels for sites at this spacing.
std::vector<double> element_integrals(const Mesh& mesh, const Basis& basis, double spacing, const Execution& execution);

/// `sites` receive their areas, the integrals of the basis functions (unless `neighbour_areas`), and the basis is
/// bound to them, unless it is already. Phases: "set up basis", "divide surface", "set up projection".
Discretisation discretise(const Mesh& mesh, std::shared_ptr<SiteSet> sites, std::shared_ptr<Basis> basis,
                          const ProjectionChoice& projection, bool neighbour_areas, std::uint64_t seed,
                          const Execution& execution);

/// The same with given points where light is gathered, in place of those of `projection_points`; the sites are first.
Discretisation discretise(const Mesh& mesh, std::shared_ptr<SiteSet> sites, std::shared_ptr<Basis> basis,
                          const ProjectionChoice& projection, bool neighbour_areas, std::vector<SurfacePoint> points,
                          const Execution& execution);

} // namespace difusa
