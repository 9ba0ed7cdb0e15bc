#include <difusa/bake.h>

#include <difusa/bake/adaptive_sites.h>
#include <difusa/bake/choices.h>
#include <difusa/bake/cost.h>
#include <difusa/bake/error_target.h>
#include <difusa/bake/evaluation.h>
#include <difusa/bake/fronts.h>
#include <difusa/bake/placing.h>
#include <difusa/bake/scene.h>
#include <difusa/bake/sensing.h>
#include <difusa/bake/sites_in_sight.h>
#include <difusa/bake/steps.h>
#include <difusa/bake/subdivided_patches.h>
#include <difusa/bake/trial.h>
#include <difusa/core/error.h>
#include <difusa/rays/unfolded_visibility.h>

#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace difusa {

namespace {

/// Refuses what cannot go over mirrors, if there are any.
void refuse_for_mirrors(const BakeResult& result, const Choices& choices) {
    if (!result.scene->mesh.mirrors.any()) {
        return;
    }
    if (choices.analytic == AnalyticUse::always) {
        throw UsageError("--analytic always: " + result.file +
                         " has mirrors, whose images have no exact form factors; omit it");
    }
    if (choices.pairwise) {
        if (!result.scene->mesh.mirrors.is_grey()) {
            throw UsageError("--transport " + result.options.transport + ": " + result.file +
                             " has coloured mirrors, and pairwise transport has one form factor for all channels; use "
                             "--transport gather");
        }
        return;
    }
    if (choices.solver->needs_factors()) {
        throw UsageError("--solver " + result.options.solver + ": " + result.file +
                         " has mirrors, and relaxing one unknown after the other needs rows that do not go over "
                         "mirrors; use krylov or jacobi, or --transport pairwise");
    }
}

/// Refuses what glossy reflection cannot be combined with, if there is any.
void refuse_for_gloss(const BakeResult& result, const Choices& choices) {
    if (!result.scene->mesh.glossy.any()) {
        return;
    }
    if (choices.pairwise) {
        throw UsageError(
            "--transport " + result.options.transport + ": " + result.file +
            " has glossy materials, which pairwise transport does not know; use --transport gather, or --no-gloss");
    }
    if (choices.solver->needs_factors()) {
        throw UsageError("--solver " + result.options.solver + ": " + result.file +
                         " has glossy materials, and relaxing one unknown after the other needs rows that do not go "
                         "over these; use krylov or jacobi, or --no-gloss");
    }
}

/// Refuses what symmetry planes and periods cannot be combined with, if there are any.
void refuse_for_repetition(const BakeResult& result, const Choices& choices) {
    if (!result.scene->mesh.repetition.any()) {
        return;
    }
    if (choices.analytic == AnalyticUse::always) {
        throw UsageError("--analytic always: " + result.file +
                         " has symmetry planes or periods, beyond which nothing is known to be seen whole; omit it");
    }
    if (choices.pairwise) {
        throw UsageError("--transport " + result.options.transport + ": " + result.file +
                         " has symmetry planes or periods, over which pairwise transport does not see; use --transport "
                         "gather");
    }
}

/// Builds the engine, and settles which sides are fronts.
void build_visibility(BakeResult& result, const Registry& registry, Choices& choices, const Execution& execution) {
    refuse_for_mirrors(result, choices);
    refuse_for_repetition(result, choices);
    refuse_for_gloss(result, choices);
    execution.phase("build ray tree");
    choices.engine = built_over(result.scene->mesh, choices.engine);
    if (result.scene->thermal && choices.flip == Flip::certain) { // which side is warm does not tell fronts from backs
        choices.flip = Flip::nothing;
    }
    const bool turned = settle_fronts(result, choices, execution);
    if (settle_coplanar_faces(result, execution) || turned) {
        choices.engine = built_over(result.scene->mesh, registry.create<Visibility>(choices.visibility));
    }
    open_if_seen_from_outside(result);
    if (result.options.when_visible) {
        result.options.when_visible(*result.scene, *choices.engine, result.camera, result.up);
    }
}

/// What bakes, dry runs and attempts at an accuracy have in common.
struct Stage {
    const Registry& registry;
    Tracer tracer;
    DirectLight lights;
    LitSurface lit;
    Stage(const BakeResult& result, const Registry& registry_used, const Choices& choices, const Execution& execution)
        : registry(registry_used), tracer(result.scene->mesh, *choices.engine), lights(*result.scene, tracer),
          lit(lit_surface(result, lights, tracer, execution)) {}
};

Placed place_evenly(const Stage& stage, const BakeResult& result, const Choices& choices, const Execution& execution) {
    return with_sites_in_sight(result, stage.registry, choices, stage.lit, stage.tracer,
                               place_sites(result, choices, stage.lit, execution), execution,
                               [&](std::vector<SurfacePoint> points, double spacing) {
                                   return site_set_of(result, stage.lit, std::move(points), spacing, execution);
                               });
}

/// Places the sites and solves. `known`, if not null: what an earlier bake of the scene tells, if there is one; then
/// what this one does.
void solve_on(const Stage& stage, BakeResult& result, const Choices& choices, std::optional<Judged>* known,
              const Execution& execution) {
    // An accuracy can be ordered from any sampler.
    result.options.adaptive = result.options.adaptive && !choices.sampler->needs_visibility();
    execution.phase("place sites");
    choose_spacing(result, choices, stage.lit, execution);
    check_request(result, execution);
    const auto place = [&]() -> Placed {
        if (!result.options.adaptive) {
            return place_evenly(stage, result, choices, execution);
        }
        if (result.options.sites > 0) { // before time is spent on pilots
            estimate_cost(result, choices, stage.lights, result.options.sites, execution);
        }
        if (is_subdivided(*choices.elements.basis, result.options)) {
            return place_elements(result, stage.registry, choices, stage.lit, stage.tracer, execution);
        }
        if (const std::optional<Placed> graded =
                place_adaptively(result, stage.registry, choices, stage.lit, stage.tracer,
                                 known != nullptr ? *known : std::nullopt, execution)) {
            return *graded;
        }
        result.options.adaptive = false;
        execution.phase("place sites");
        return place_evenly(stage, result, choices, execution);
    };
    const Placed placed = place();
    result.sites = placed.sites;
    result.estimate = estimate_cost(result, choices, stage.lights, placed.sites->size(), execution);
    solve_placed(result, choices, placed, transport_by_rays(result, choices, stage.tracer), execution);
    estimate_error_of(result, execution);
    if (known != nullptr) {
        *known = judged_by(result, placed, execution);
    }
}

/// Estimates the cost, placing sites only where that is cheap.
void forecast(BakeResult& result, const Registry& registry, const Choices& choices, const Execution& execution) {
    const Stage stage(result, registry, choices, execution);
    const LitSurface& lit = stage.lit;
    const std::optional<std::size_t> many = forecast_sites(result, choices, lit, execution);
    // Graded sites follow from the light, of which a dry run knows nothing: as many as are wanted, unless most of them
    // are needed for one on each region, which placing them evenly tells.
    const std::size_t half = result.options.sites / 2;
    const bool few_regions = result.options.adaptive && !choices.sampler->needs_visibility() &&
                             choices.elements.basis->sampler().empty() && result.scene->mesh.region_count < half;
    if (!many && !few_regions) {
        execution.phase("place sites");
        result.sites = place_evenly(stage, result, choices, execution).sites;
    }
    const std::size_t even = result.sites ? result.sites->size() : many.value_or(result.options.sites);
    const bool graded = result.options.adaptive && even < result.options.sites + half;
    const std::size_t sites = graded ? result.options.sites : even;
    result.options.adaptive = graded || (result.options.adaptive && result.options.sites == 0);
    check_request(result, execution);
    result.estimate = estimate_cost(result, choices, stage.lights, sites, execution);
    result.estimate.predicted = result.options.adaptive || many;
    count_further_rays(result.estimate, result, execution);
    predict_time(
        result, registry, choices,
        [&](BakeResult& trial, Choices& own_choices, const Execution& own) {
            solve_on(stage, trial, own_choices, nullptr, own);
        },
        execution);
}

/// The steps after the scene is there.
void finish(BakeResult& result, const Registry& registry, Choices& choices, const Execution& execution) {
    const Stage stage(result, registry, choices, execution);
    if (result.options.target) {
        const BakeOptions wanted = result.options;
        std::optional<Judged> known; // of the attempt before
        const auto solve_afresh = [&](BakeResult& attempt, const Execution& own) {
            Choices fresh = make_choices(registry, wanted); // a basis is bound to the sites of one attempt
            choices.elements = std::move(fresh.elements);
            choices.fallback = std::move(fresh.fallback);
            solve_on(stage, attempt, choices, &known, own);
        };
        reach_target(result, solve_afresh, execution);
    } else {
        solve_on(stage, result, choices, nullptr, execution);
    }
    evaluate_solution(result, execution);
}

} // namespace

BakeResult bake(const Registry& registry, const std::filesystem::path& file, const BakeOptions& options,
                const Execution& execution) {
    return run_steps(registry, options, execution, [&](BakeResult& result, Choices& choices, const Execution& own) {
        read_into(result, registry, file, own);
        build_visibility(result, registry, choices, own);
        finish(result, registry, choices, own);
    });
}

BakeResult bake(const Registry& registry, Scene scene, const std::string& name, const BakeOptions& options,
                const Execution& execution) {
    return run_steps(registry, options, execution, [&](BakeResult& result, Choices& choices, const Execution& own) {
        adopt_into(result, std::move(scene), name, own);
        if (choices.flip == Flip::certain) { // a program knows its fronts, and may light them otherwise later
            choices.flip = Flip::nothing;
        }
        build_visibility(result, registry, choices, own);
        finish(result, registry, choices, own);
    });
}

BakeResult dry_run(const Registry& registry, const std::filesystem::path& file, const BakeOptions& options,
                   const Execution& execution) {
    return run_steps(registry, options, execution, [&](BakeResult& result, Choices& choices, const Execution& own) {
        if (options.target) {
            throw UsageError("a dry run cannot tell what --error will take: sites and rays follow from attempts");
        }
        read_into(result, registry, file, own);
        build_visibility(result, registry, choices, own);
        forecast(result, registry, choices, own);
        result.dry_run = true;
    });
}

} // namespace difusa
