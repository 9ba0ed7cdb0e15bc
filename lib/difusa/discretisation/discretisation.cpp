#include <difusa/discretisation/discretisation.h>

#include <difusa/core/error.h>

#include <utility>

namespace difusa {

namespace {

/// A_i = sum over the surfels of A_s P_si.
std::vector<double> integrate(const Surfels& surfels, const BasisAverages& averages, const Execution& execution) {
    Values area(static_cast<Eigen::Index>(surfels.size()), 1), integrals;
    for (Index s = 0; s < surfels.size(); ++s) {
        area(s, 0) = surfels.area(s);
    }
    averages.apply_transpose(area, integrals, execution);
    return {integrals.data(), integrals.data() + integrals.size()};
}

} // namespace

std::vector<double> element_integrals(const Mesh& mesh, const Basis& basis, double spacing,
                                      const Execution& execution) {
    const Surfels surfels(mesh, Discretisation::surfel_edge(spacing), execution);
    return integrate(surfels, BasisAverages(basis, surfels, execution), execution);
}

Discretisation discretise(const Mesh& mesh, std::shared_ptr<SiteSet> sites, std::shared_ptr<Basis> basis,
                          const ProjectionChoice& projection, bool neighbour_areas, std::uint64_t seed,
                          const Execution& execution) {
    std::vector<SurfacePoint> points = projection_points(projection, mesh, *sites, seed);
    return discretise(mesh, std::move(sites), std::move(basis), projection, neighbour_areas, std::move(points),
                      execution);
}

Discretisation discretise(const Mesh& mesh, std::shared_ptr<SiteSet> sites, std::shared_ptr<Basis> basis,
                          const ProjectionChoice& projection, bool neighbour_areas, std::vector<SurfacePoint> points,
                          const Execution& execution) {
    Discretisation result;
    result.sites = sites;
    result.basis = basis;
    execution.phase("set up basis");
    if (basis->size() == 0) {
        basis->bind(mesh, *sites, execution);
    }
    DIFUSA_REQUIRE(basis->size() == sites->size(), "a basis belongs to the sites that it was bound to");

    execution.phase("divide surface");
    result.surfels = std::make_shared<Surfels>(mesh, Discretisation::surfel_edge(sites->spacing), execution);
    result.averages = std::make_shared<BasisAverages>(*basis, *result.surfels, execution);
    const Substructure* const parts = basis->substructure(); // which surfels may be larger than
    result.integrals = parts != nullptr ? parts->area : integrate(*result.surfels, *result.averages, execution);
    std::vector<Surfels::Piece> scratch;
    for (Index s = 0; s < result.surfels->size(); ++s) {
        if (result.averages->is_empty(s) && !sites->is_dark(mesh.region[result.surfels->centre(s, scratch).face])) {
            result.uncovered += result.surfels->area(s);
        }
    }
    if (!neighbour_areas) {
        sites->area = result.integrals;
    }

    execution.phase("set up projection");
    result.points = std::move(points);
    const auto project = [&](const ProjectionChoice& choice) {
        return std::make_shared<Projection>(*basis, *sites, choice, result.points, result.integrals, execution);
    };
    ProjectionChoice equation = projection;
    if (projection.kind == ProjectionKind::corrected && !projection.in_equation) {
        equation.kind = ProjectionKind::natural;
    }
    ProjectionChoice field = projection;
    if (projection.kind == ProjectionKind::substructured) {
        field.kind = ProjectionKind::natural;
    }
    result.projection = project(equation);
    result.evaluation = equation.kind == field.kind ? result.projection : project(field);
    return result;
}

} // namespace difusa
