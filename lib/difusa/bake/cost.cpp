#include <difusa/bake/cost.h>

#include <difusa/algebra/sparse_rows.h>
#include <difusa/bake/adaptive_sites.h>
#include <difusa/bake/pilot.h>
#include <difusa/core/memory.h>
#include <difusa/discretisation/discretisation.h>
#include <difusa/lighting/surfel_light.h>
#include <difusa/mesh/output_mesh.h>
#include <difusa/radiosity/error_estimate.h>
#include <difusa/rays/sky_openings.h>
#include <difusa/rays/tracer.h>
#include <difusa/scene/sky_parts.h>
#include <difusa/transport/glossy_rays.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace difusa {

namespace {

constexpr double bytes_per_ray = 2.5;                              ///< in HitLists, an upper estimate
constexpr double bytes_per_entry = sizeof(Index) + sizeof(double); ///< in SparseRows
constexpr double bytes_per_surfel = 250.0;                         ///< surfel, averages and light
constexpr double bytes_per_site = 1000.0;                          ///< with its neighbours and basis functions
constexpr double bytes_per_output_triangle = 500.0;                ///< including its share of vertices and arrays
constexpr double vectors_of_error_solve = 5.0; ///< of surfels, while the error estimate follows bounces
constexpr double pooled_directions = 32.0;     ///< sets of directions in a DirectionPool

/// Number of surfels to expect; an upper estimate.
double surfels_of(const Mesh& mesh, double edge) {
    double in_grids = 0.0, small = 0.0, small_area = 0.0;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        double longest = 0.0;
        for (int k = 0; k < 3; ++k) {
            longest = std::max(longest, (mesh.corner(t, (k + 1) % 3) - mesh.corner(t, k)).norm());
        }
        if (longest > edge) {
            // Half the squares of the rectangle, plus those the two other sides cross.
            const double across = std::ceil(longest / edge), up = std::ceil(2.0 * mesh.areas[t] / longest / edge);
            in_grids += std::min(across * up, 0.5 * across * up + across + up);
        } else {
            small += 1.0;
            small_area += mesh.areas[t];
        }
    }
    // A plane crosses at most sqrt(3) cubes per square of area; curved surfaces turn sideways in some.
    return in_grids + std::min(small, 3.0 * small_area / (edge * edge) + 1.0);
}

/// What a solver stores of the transport beside it, in bytes; an upper estimate.
double solver_bytes(const Solver& solver, const ElementChoice& elements, const BakeOptions& options, double surfels,
                    double stored_entries) {
    if (!solver.needs_factors()) {
        return 0.0;
    }
    // Basis functions over a surfel; those that a correction mixes reach further by their radius with each sweep.
    double reach = 1.0;
    if (elements.projection.kind == ProjectionKind::corrected && elements.projection.in_equation) {
        reach += elements.projection.sweeps;
    }
    const double entries = surfels * (options.neighbours + 1) * reach * reach;
    const double channels = 3.0;
    return entries * 2.0 * (sizeof(Index) + channels * sizeof(double)) +
           (solver.needs_columns() ? stored_entries * (sizeof(Index) + sizeof(double)) : 0.0);
}

/// Rays to mirror patches and on from them, as long as none is quartered and paths go over one mirror.
std::size_t rays_over_mirrors(std::size_t sites, const BakeResult& result, const Choices& choices) {
    const double edge = choices.over_mirrors.granularity * result.options.spacing;
    return 2 * sites * mirror_patch_count(result.scene->mesh, edge);
}

/// Visibility segments of a bake up to its field, if every surfel and every point lies in a penumbra.
std::size_t most_segments(std::size_t sites, const BakeResult& result, const Choices& choices,
                          const DirectLight& lights) {
    const std::size_t points = gather_points(choices.elements.projection, sites);
    const SurfelSamples samples = SurfelSamples::of(lights.rays_per_sample());
    const std::size_t on_surfel = samples.pilot + samples.edge;
    const double on_surfels = expected_surfels(result) * static_cast<double>(on_surfel * lights.rays_per_sample());
    std::size_t segments =
        static_cast<std::size_t>(on_surfels) + points * lights.most_rays_per_point(result.options.shadow_rays);
    if (lights.any() || result.scene->has_uneven_emitters()) {
        segments += points * ((result.options.rays + 1) / 2); // towards samples on bright surfels
    }
    if (result.options.adaptive) {
        segments += static_cast<std::size_t>(pilot_sites * static_cast<double>(segments));
    }
    return choices.pairwise ? segments + sites * (sites - 1) / 2 + rays_over_mirrors(sites, result, choices) : segments;
}

/// What glossy surfaces take of the transport, in bytes: rays from them and towards them, the weights of the elements
/// on their surfels, and coefficients of these while they are summed.
double glossy_bytes(const BakeResult& result, double points, double rays, double surfels) {
    const Mesh& mesh = result.scene->mesh;
    double area = 0.0;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        area += mesh.glossy.kind(t) != none ? mesh.areas[t] : 0.0;
    }
    const double share = area / mesh.area, seen = std::min(1.0, 2.0 * share);
    const double harmonics = std::pow(result.options.directional_order + 1.0, 2.0) * 3.0 * sizeof(double);
    constexpr double copies = 4.0; // coefficients at a time
    return points * rays * (share + (1.0 - share) * seen) * sizeof(GlossyRays::Ray) +
           surfels * share * (result.options.neighbours + 1) * sizeof(std::pair<Index, double>) +
           (surfels + points) * share * harmonics * copies;
}

/// BakeEstimate::other_bytes. The error estimate solves for each group of its points.
double other_bytes(const BakeResult& result, std::size_t sites) {
    const double solve = error_points(result.options, sites) == 0
                             ? 0.0
                             : expected_surfels(result) * vectors_of_error_solve * ErrorPoints::groups *
                                   static_cast<double>(result.channels) * sizeof(double);
    const double output =
        bytes_per_output_triangle * expected_output_triangles(result.scene->mesh, result.options.output_spacing);
    return bytes_per_site * static_cast<double>(sites) + std::max(solve, output);
}

/// Of one point's row, in bytes; an upper estimate.
double row_bytes(const Directions& directions, double rays, double bins) {
    return directions.equal_weights() ? rays * bytes_per_ray
                                      : std::min(rays, bins) * bytes_per_entry + sizeof(SparseRows::Row);
}

} // namespace

std::size_t gather_points(const ProjectionChoice& projection, std::size_t sites) {
    const bool more = projection.kind == ProjectionKind::least_squares || projection.kind == ProjectionKind::galerkin;
    return more ? sites + static_cast<std::size_t>((projection.points - 1.0) * static_cast<double>(sites)) : sites;
}

std::size_t most_output_triangles(const Execution& execution) {
    return static_cast<std::size_t>(static_cast<double>(execution.memory_left()) / bytes_per_output_triangle);
}

OutputMesh output_mesh(const BakeResult& result, const Execution& execution) {
    return refine(result.scene->mesh, result.options.output_spacing, most_output_triangles(execution), execution,
                  result.scene->texture_seams());
}

std::size_t error_points(const BakeOptions& options, std::size_t sites) {
    const std::size_t wanted = options.error_points.value_or(std::clamp<std::size_t>(sites / 8, 400, 4096));
    return (wanted + ErrorPoints::groups - 1) / ErrorPoints::groups * ErrorPoints::groups;
}

std::size_t error_rays(const BakeOptions& options) {
    return std::max<std::size_t>(1, options.rays / 4);
}

BakeEstimate estimate_cost(const BakeResult& result, const Choices& choices, const DirectLight& lights,
                           std::size_t sites, const Execution& execution) {
    BakeEstimate estimate;
    estimate.sites = sites;
    const std::size_t points = gather_points(choices.elements.projection, sites);
    const auto n = static_cast<double>(sites), bins = expected_surfels(result) + SkyParts::count;
    const std::size_t rays_of_point = choices.directions->size(result.options.rays);
    const auto rays = static_cast<double>(rays_of_point);
    estimate.rays = points * rays_of_point;
    if (result.options.adaptive) {
        estimate.rays += static_cast<std::size_t>(pilot_sites * n) * pilot_rays(result.options.rays);
    }
    estimate.segments = most_segments(sites, result, choices, lights);
    estimate.transport_bytes = static_cast<double>(points) * row_bytes(*choices.directions, rays, bins) +
                               expected_surfels(result) * bytes_per_surfel;
    if (choices.analytic == AnalyticUse::always) { // groups are fewer than rays, and have a mean and moments
        estimate.transport_bytes += SurfelGroups::moments * static_cast<double>(points) * rays * bytes_per_entry;
    }
    if (choices.aims_at_openings && result.scene->has_sky()) { // entries of rays to openings
        const auto most =
            static_cast<double>(std::min<std::size_t>(SkyOpenings::aimed(rays_of_point), SkyParts::count));
        estimate.transport_bytes += static_cast<double>(points) * (most * bytes_per_entry + sizeof(SparseRows::Row));
    }
    if (result.scene->mesh.glossy.any()) {
        estimate.transport_bytes += glossy_bytes(result, static_cast<double>(points), rays, expected_surfels(result));
    }
    if (choices.pairwise) {
        // Lists of mutually visible sites, then the matrix.
        estimate.transport_bytes += n * n * (2.0 * sizeof(Index) + sizeof(double));
    }
    const double stored_entries = choices.pairwise ? n * n : static_cast<double>(points) * rays;
    estimate.transport_bytes +=
        solver_bytes(*choices.solver, choices.elements, result.options, expected_surfels(result), stored_entries);
    // Directions are pooled; each thread holds the rays and hits of one site.
    const double scratch =
        rays * (pooled_directions * 4.0 * sizeof(double) + execution.threads * (sizeof(Ray) + sizeof(Hit)));
    estimate.other_bytes = other_bytes(result, sites);
    require_memory(estimate.transport_bytes + scratch + estimate.other_bytes, execution.memory_left(),
                   "a bake of " + std::to_string(sites) + " sites and its output",
                   result.options.target ? "ask for a larger --error, or allow more memory"
                   : choices.pairwise    ? "give a larger --spacing, or use --transport gather"
                                         : "give a larger --spacing, or fewer --rays");
    return estimate;
}

double expected_surfels(const BakeResult& result) {
    return surfels_of(result.scene->mesh, Discretisation::surfel_edge(result.options.spacing));
}

void count_further_rays(BakeEstimate& estimate, const BakeResult& result, const Execution& execution) {
    const BakeOptions& options = result.options;
    const std::size_t points = error_points(options, estimate.sites);
    const std::size_t first = points < 2 * few_error_points ? 0 : few_error_points; // those that others replace
    std::size_t samples = 0; // of goals; as many more, at most, are on paths from places
    for (const GoalRequest& goal : options.goals) {
        samples += goal.places.empty() ? options.goal_samples / 2 : options.goal_samples;
    }
    estimate.further_rays = 2 * error_rays(options) * (points + first + samples);
    if (options.final_gather > 0) {
        estimate.further_rays += 2 * output_mesh(result, execution).vertices.size() * ((options.final_gather + 1) / 2);
    }
}

} // namespace difusa
