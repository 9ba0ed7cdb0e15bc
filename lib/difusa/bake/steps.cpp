#include <difusa/bake/steps.h>

#include <difusa/bake/evaluation.h>
#include <difusa/bake/goals.h>
#include <difusa/bake/near_lights.h>
#include <difusa/bake/sensing.h>
#include <difusa/bake/thermal.h>
#include <difusa/core/error.h>
#include <difusa/core/random.h>
#include <difusa/core/text.h>
#include <difusa/discretisation/evaluate.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/rays/unfolded_visibility.h>
#include <difusa/transport/analytic_transport.h>
#include <difusa/transport/gathered.h>
#include <difusa/transport/glossy_transport.h>
#include <difusa/transport/pairwise.h>
#include <difusa/transport/skylight.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace difusa {

namespace {

/// How well a basis whose coefficients need a solve represents the function 1 between its sites, at random surface
/// points: a basis that cannot do that will do no better on light.
void check_constants(BakeResult& result, const Discretisation& discretisation, const Execution& execution) {
    if (discretisation.projection->is_mean()) {
        return;
    }
    RandomStream stream(result.options.seed, "constants");
    std::vector<SurfacePoint> points;
    for (int i = 0; i < 4096; ++i) {
        const SurfacePoint& site = discretisation.sites->points[stream.below(discretisation.sites->size())];
        const double u = stream.uniform(), v = stream.uniform();
        points.push_back(uniform_point(result.scene->mesh, site.face, u, v));
    }
    const Values ones = Values::Ones(static_cast<Eigen::Index>(discretisation.points.size()), 1);
    Values coefficients = discretisation.projection->coefficients(ones, execution);
    // Bases that sum to one vanish only where no site is in sight, as inside of other bodies: nothing oscillates there,
    // and coefficients of 1 have no error.
    const bool sums_to_one = discretisation.basis->sums_to_one();
    coefficients.array() -= sums_to_one ? 1.0 : 0.0;
    const Values values = evaluate(*discretisation.basis, coefficients, points, execution.silent());
    result.constant_error = std::sqrt((values.array() - (sums_to_one ? 0.0 : 1.0)).square().mean());
    const std::string miss = text_of(100.0 * result.constant_error) + " % (rms)";
    if (!(result.constant_error < 0.25)) {
        throw NotConverged("the basis misses a constant by " + miss +
                           " between its sites: its coefficients oscillate. Give it another width, or use "
                           "--basis normalized-radial or shepard");
    }
    if (result.constant_error > 0.01) {
        execution.note("the basis misses a constant by " + miss + " between its sites: expect errors of that size");
    }
}

/// Notes how much of the surface and of the rays is lost.
void check_coverage(BakeResult& result, const Discretisation& discretisation, const LightTransport& transport,
                    const Execution& execution) {
    const double area = result.scene->mesh.area, uncovered = discretisation.uncovered;
    const SiteSet& sites = *discretisation.sites;
    // Bases that sum to one leave out what nothing is in sight of: no light is lost there.
    if (uncovered > 1e-3 * area && !discretisation.basis->sums_to_one()) {
        execution.note("no basis function covers " + text_of(100.0 * uncovered / area) +
                       " % of the surface: light is lost there; give the basis a larger width, or more sites");
    }
    result.mean_back += sites.mean(transport.back);
    if (transport.cut_off.rows() > 0) {
        result.mean_back += sites.mean(transport.back_in_mirrors);
        result.mean_cut_off = sites.mean(transport.cut_off);
        if (result.mean_cut_off > 1e-3) {
            const std::string share = text_of(std::round(1000.0 * result.mean_cut_off) / 10.0);
            execution.note(result.scene->mesh.repetition.any()
                               ? share +
                                     " % of the light that leaves the surface is lost in the distance: it is "
                                     "followed through at most " +
                                     std::to_string(UnfoldedVisibility::most_walls) + " periods or symmetry planes"
                               : share +
                                     " % of the light that leaves the surface is lost between mirrors: it is "
                                     "followed over at most " +
                                     std::to_string(result.options.mirror_depth) +
                                     " reflections in a row (--mirror-depth)");
        }
    }
    if (result.scene->thermal) {
        check_surroundings(result, sites, transport, execution);
        return;
    }
    if (result.mean_back > 0.1) {
        execution.note(text_of(std::round(100.0 * result.mean_back)) +
                       " % of the light paths end on back faces, which neither receive nor emit light: if the "
                       "result is too dark, turn those faces over (--flip, or in the modelling program)");
    }
}

/// Notes lobes that the harmonics blur, and glossy reflections that are cut off.
void check_lobes(BakeResult& result, const LightTransport& transport, const Execution& execution) {
    const GlossyTransport* const glossy = glossy_part(*transport.W);
    if (glossy == nullptr) {
        return;
    }
    result.glossy = GlossyResult{glossy->elements(), glossy->reflections(), 1.0};
    for (Index lobe = 0; lobe < result.scene->mesh.glossy.lobes.size(); ++lobe) {
        result.glossy->resolved = std::min(result.glossy->resolved, glossy->lobe(lobe).resolved());
    }
    if (result.glossy->resolved < 0.9) {
        execution.note("harmonics of order " + std::to_string(result.options.directional_order) + " hold " +
                       text_of(std::round(100.0 * result.glossy->resolved)) +
                       " % of the sharpest glossy lobe: light that it passes on is blurred (--directional-order)");
    }
    if (glossy->cut_off() > 1e-3) {
        execution.note("glossy reflections are followed over " + std::to_string(glossy->reflections()) +
                       " in a row; the next ones would still have about " +
                       text_of(std::round(1000.0 * glossy->cut_off()) / 10.0) + " % of the first");
    }
}

/// Enters these elements into the list of plugins.
void name_elements(BakeResult& result, const ElementChoice& elements) {
    std::erase_if(result.plugins,
                  [](const auto& plugin) { return plugin.first == "basis" || plugin.first == "projection"; });
    result.plugins.emplace_back("basis", elements.basis_text);
    result.plugins.emplace_back("projection", elements.projection_text);
}

/// Where light is gathered: the sites, and for some projections points besides.
std::vector<SurfacePoint> points_of_gathering(const BakeResult& result, const ProjectionChoice& projection,
                                              const Placed& placed) {
    const Mesh& mesh = result.scene->mesh;
    const SiteSet& sites = *placed.sites;
    std::vector<SurfacePoint> points =
        projection_points(projection, placed.unmoved ? *placed.unmoved : mesh, sites, result.options.seed);
    if (placed.unmoved) {
        for (std::size_t q = sites.size(); q < points.size(); ++q) {
            points[q] = mesh.shaded(mesh.at(points[q].face, points[q].u, points[q].v));
        }
    }
    return points;
}

/// The system of these elements and its solution. `transport`: that of other elements on the same sites, if any.
void solve_with(BakeResult& result, const ElementChoice& elements, const Choices& choices, const Placed& placed,
                const TransportSource& source, std::optional<LightTransport>& transport, const Execution& execution) {
    name_elements(result, elements);
    Discretisation discretisation =
        discretise(result.scene->mesh, placed.sites, elements.basis, elements.projection, choices.neighbour_areas,
                   points_of_gathering(result, elements.projection, placed), execution);
    check_constants(result, discretisation, execution);
    const bool first = !transport.has_value();
    if (first) {
        transport = source(discretisation, execution);
        transport = with_analytic_factors(std::move(*transport), result.scene->mesh, discretisation.points,
                                          *discretisation.surfels, choices.analytic, execution);
        const auto* const analytic = dynamic_cast<const AnalyticTransport*>(transport->W.get());
        if (choices.aims_at_openings && result.scene->has_sky()) {
            transport = with_skylight(std::move(*transport), {result.scene->mesh, *choices.engine},
                                      discretisation.points, *choices.directions, result.options.seed, execution);
        }
        result.options.analytic = analytic != nullptr ? "always" : "never"; // so that a saved transport is solved alike
        result.analytic_share = analytic != nullptr ? analytic->share() : 0.0;
    }
    LightTransport reflected =
        with_gloss(*transport, discretisation, result.scene->mesh.glossy, result.options.directional_order, execution);
    if (first) {
        check_coverage(result, discretisation, reflected, execution);
        check_lobes(result, reflected, execution);
    }
    result.system = std::make_shared<RadiositySystem>(
        SystemParts{result.scene, choices.engine, choices.directions, choices.solver, std::move(discretisation),
                    std::move(reflected), result.options.seed, choices.fresh_directions,
                    placed.elements == elements.text() ? placed.contraction : std::nullopt});
    result.elements = elements.text();
    try {
        find_temperatures(result, lighting_options(result, choices), execution);
        result.solution = result.system->solve(result.scene, lighting_options(result, choices), execution);
    } catch (const InputError& error) {
        throw InputError(result.file + ": " + error.what());
    }
}

} // namespace

BakeResult run_steps(const Registry& registry, const BakeOptions& options, const Execution& execution,
                     const BakeSteps& steps) {
    Choices choices = make_choices(registry, options);
    BakeResult result;
    result.requested = options;
    result.options = options;
    result.photometric = options.units == "photometric";
    result.threads = execution.threads;
    result.options.visibility = choices.visibility;
    result.options.sampler = choices.sampler_name;
    result.options.sensor = choices.sensor;
    result.plugins = choices.plugins;
    name_elements(result, choices.elements);
    Journal journal;
    const Execution own = execution.with(execution.progress, &journal);
    for (const std::string& note : choices.notes) {
        own.note(note);
    }
    const auto hand_over = [&] {
        journal.end();
        if (execution.journal != nullptr) {
            execution.journal->append(journal);
        }
    };
    try {
        steps(result, choices, own);
    } catch (...) {
        hand_over();
        throw;
    }
    hand_over();
    result.journal = std::move(journal);
    return result;
}

void check_request(BakeResult& result, const Execution& execution) {
    check_output(result, execution);
    find_places(result, execution);
    check_places(result);
    result.goals = find_goals(result.options.goals, *result.scene, result.options.spacing, execution);
}

TransportSource transport_by_rays(const BakeResult& result, const Choices& choices, const Tracer& tracer) {
    return [&, tracer](const Discretisation& discretisation, const Execution& execution) {
        execution.phase("transport");
        const BakeOptions& options = result.options;
        LightTransport transport = choices.pairwise
                                       ? pairwise(tracer, discretisation, *choices.kernel, choices.over_mirrors,
                                                  *choices.directions, options.rays, options.seed, execution)
                                       : gathered(tracer, discretisation.points, *discretisation.surfels,
                                                  *choices.directions, options.rays, options.seed, execution);
        execution.count("rays", transport.rays);
        execution.count("segments", transport.segments);
        return transport;
    };
}

LightingOptions lighting_options(const BakeResult& result, const Choices& choices) {
    LightingOptions options;
    options.sets = result.options.light_groups ? light_groups(*result.scene) : all_lights(*result.scene);
    options.direct_in_basis = choices.direct_in_basis;
    options.shadow_rays = result.options.shadow_rays;
    options.solve = result.options.solve;
    options.solve.stop = choices.stop_by_change ? StopBy::change : StopBy::residual;
    options.keep_iterates = result.options.keep_iterates;
    options.may_be_dark = choices.may_be_dark || result.scene->thermal.has_value(); // all as warm as the surroundings
    options.first_bounce = choices.operator_bounce ? FirstBounce::operator_only : FirstBounce::live;
    return options;
}

void solve_placed(BakeResult& result, const Choices& choices, const Placed& placed, const TransportSource& source,
                  const Execution& execution) {
    std::optional<LightTransport> transport;
    try {
        ElementChoice elements = choices.elements;
        if (placed.basis) {
            elements.basis = placed.basis;
        }
        solve_with(result, elements, choices, placed, source, transport, execution);
    } catch (const BouncesDoNotDieOut&) {
        if (!choices.fallback) {
            throw;
        }
        execution.note("with --basis " + choices.elements.basis_text +
                       ", the default, the bounces do not die out: normalized-radial is used, with which they do "
                       "unless the surfaces absorb nothing");
        solve_with(result, *choices.fallback, choices, placed, source, transport, execution);
    }
}

void evaluate_solution(BakeResult& result, const Execution& execution) {
    note_near_lights(*result.scene, result.system->tracer(), result.system->discretisation().surfels->size(),
                     execution);
    estimate_goals_of(result, execution);
    refine_output(result, execution);
    evaluate_output(result, execution);
    evaluate_thermal(result, execution);
    list_savings(result, execution);
}

void evaluate_anew(BakeResult& result, const Execution& execution) {
    estimate_goals_of(result, execution);
    evaluate_output(result, execution);
    evaluate_thermal(result, execution);
}

} // namespace difusa
