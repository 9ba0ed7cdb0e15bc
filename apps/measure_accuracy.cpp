// measure_accuracy --output DIR: speed against error, on scenes whose radiosity is known. Parses options, runs the
// study, writes files.
#include "accuracy_studies.h"
#include "bake_arguments.h"
#include "terminal.h"

#include <difusa/core/text.h>
#include <difusa/discretisation/projection.h>
#include <difusa/import/file_content.h>
#include <difusa/io/field_file.h>
#include <difusa/rays/visibility_choice.h>
#include <difusa/study/estimate_study.h>
#include <difusa/study/solver_study.h>
#include <difusa/study/study.h>
#include <difusa/study/validation.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace measure_accuracy {

using difusa::add_whole;
using difusa::shown;
using difusa::UsageError;

const char* const examples =
    R"(Bakes scenes whose radiosity is known exactly, and reports how fast and how accurate each method is.

Examples:
  measure_accuracy --output study
      all cases, four bases with and without projection; tables, charts, CSV and JSON in study/
  measure_accuracy --output study --case ball-over-disc --basis shepard --basis normalized-radial --spacing 3 --spacing 1
      two bases at two spacings; options that may be repeated are combined with each other
  measure_accuracy --output study --case ball-over-disc --projection galerkin --rays 1024 --rays 16384
      how much additional rays help
  measure_accuracy --output study --chapter7
      the dissertation's chapter 7: curves over ball and disc for its three bases, as printed and as implemented here

  measure_accuracy --output study --estimate 200 --case bowl --scene data/cornell_box.obj
      how often the error estimate holds, and how close it is, over 200 seeds; scenes are judged by finer bakes
  measure_accuracy --output study --estimate 20 --error 1% --scene data/cornell_box.obj
      whether an accuracy that is ordered is reached, and what it takes

  measure_accuracy --output study --solver krylov --solver jacobi --solver progressive --scene data/room_a.json
      what solvers need, on the same system: iterations, matrix entries, time

  measure_accuracy --output study --side-by-side --case ball-over-disc --scene data/room_a.json --places 1000
      the classical method (patches or vertices of a mesh, hemicubes) beside the meshless one: error, time, memory

  measure_accuracy --output study --defaults --scene data/cornell_box.obj --places 2000 --beside "path tracer=48,0.34%"
      the default options beside others, and a figure measured elsewhere in the chart

  measure_accuracy --output study --subdivision --case ball-over-disc
      patches divided where the light varies beside even meshes: elements, unknowns, rays and time for an error

  measure_accuracy --output study --validation cie-171
      published validation cases of lighting programs, CIE 171:2006 (data/VALIDATION.md)
  measure_accuracy --output study --validation cie-171 --case 5.11 --rays 8192
      those whose names begin with 5.11, with more rays

  measure_accuracy --output study --mirrors
      form factors over mirror patches: errors by their granularity, and the distance of what they show (data/MIRRORS.md)
  measure_accuracy --output study --gloss --sites 2000
      glossy floors against path tracing, by lobe and order of the harmonics (data/GLOSS.md)

  measure_accuracy --output study --shelf
      shelves of growing length towards the infinite one, whose form factors and radiosity are known
  measure_accuracy --output study --edges
      how the light varies near edges where walls meet, by their reflectance, and the order of convergence there

Cases:%CASES%

Exit codes: 0 done, 1 usage, 2 input, 3 not converged, 4 resources, 5 internal, 130 interrupted.
)";

struct Arguments {
    std::filesystem::path output;
    difusa::StudyPlan plan;
    std::size_t repeats = 1;
    bool chapter7 = false;
    std::size_t estimate = 0; ///< bakes
    std::vector<std::string> scenes;
    std::optional<double> error; ///< target of those bakes
    std::vector<std::string> solvers;
    std::vector<double> albedos;
    std::optional<std::size_t> sites; ///< of those systems
    bool side_by_side = false, subdivision = false, shelf = false, edges = false, defaults = false;
    std::vector<difusa::MeasuredElsewhere> beside;
    std::string validation; ///< name of the collection
    bool mirrors = false, gloss = false;
    difusa::RunArguments run;
};

/// "NAME=SECONDS,ERROR%"
difusa::MeasuredElsewhere parse_elsewhere(const std::string& option, const std::string& text) {
    const std::size_t equals = text.rfind('='), comma = text.rfind(',');
    if (equals == std::string::npos || equals == 0 || comma == std::string::npos || comma < equals) {
        throw UsageError(option + " " + text + ": must be NAME=SECONDS,ERROR%, as in \"path tracer=48,0.34%\"");
    }
    const std::string whole = option + " " + text + ":";
    return {text.substr(0, equals), difusa::parse_positive(whole, text.substr(equals + 1, comma - equals - 1)),
            difusa::parse_percent(whole, text.substr(comma + 1))};
}

double parse_albedo(const std::string& option, const std::string& text) {
    const double albedo = difusa::parse_positive(option, text);
    if (!(albedo < 1.0)) {
        throw UsageError(option + " " + text + ": must be above 0 and below 1");
    }
    return albedo;
}

void declare(CLI::App& app, Arguments& a) {
    app.add_option("--output", a.output, "directory for the tables and charts; created if it does not exist")
        ->type_name("DIR");
    const std::string what = "What is measured (all may be repeated)";
    const auto words = [&](const std::string& name, std::vector<std::string>& target, const std::string& meaning) {
        difusa::add_repeated(app, name, target, meaning)->group(what)->type_name("NAME");
    };
    words("--case", a.plan.cases, "scene with a known solution (default: all)");
    words("--basis", a.plan.bases, "default: radial, normalized-radial, shepard, moving-least-squares");
    words("--projection", a.plan.projections, "default: natural, galerkin");
    words("--transport", a.plan.transports, "default: gather");
    const auto numbers = [&](const std::string& name, auto& target, const std::string& meaning, auto parse) {
        difusa::add_repeated(app, name, target, meaning, parse)->group(what)->type_name("N");
    };
    const auto whole = [](const std::string& option, const std::string& text) {
        return difusa::parse_whole<std::size_t>(option, text, 0);
    };
    numbers("--spacing", a.plan.spacings,
            "site spacing, in units of the case (default: each case's own, coarse to fine)", difusa::parse_positive);
    numbers("--rays", a.plan.rays,
            "rays from each point where light is gathered (default: 1024; of the bakes of scenes, 512)",
            [](const std::string& option, const std::string& text) {
                return difusa::parse_whole<std::size_t>(option, text, 1);
            });
    numbers("--final-gather", a.plan.final_gathers, "rays at each point that is assessed (default: 0, the basis)",
            whole);
    app.add_flag("--chapter7", a.chapter7, "curves of the ball over the disc instead, as in the dissertation");

    add_whole<std::size_t>(app, "--estimate", a.estimate, 1,
                           "bakes of each case and scene instead, to judge the error estimate")
        ->type_name("N");
    difusa::add_repeated(app, "--scene", a.scenes,
                         "mesh or scene file to bake with --estimate, --solver, --side-by-side, --defaults or "
                         "--subdivision (may be repeated)")
        ->type_name("FILE");
    difusa::add_repeated(app, "--solver", a.solvers,
                         "solvers instead, against each other on each --scene (may be repeated)")
        ->type_name("NAME");
    difusa::add_repeated(app, "--albedo", a.albedos,
                         "reflectance of all surfaces for --solver (may be repeated; default: 0.5, 0.9, 0.99)",
                         parse_albedo)
        ->type_name("R");
    difusa::add_parsed(
        app, "--sites", a.sites,
        "sites of those systems, if no --spacing is given (default: 2000), or of --side-by-side and --defaults",
        [](const std::string& option, const std::string& text) {
            return difusa::parse_whole<std::size_t>(option, text, 1);
        })
        ->type_name("N");

    app.add_flag("--side-by-side", a.side_by_side,
                 "the classical method beside the meshless one instead, on each --case and --scene (default sites: 500 "
                 "and 2000)");
    app.add_flag("--defaults", a.defaults,
                 "the default options beside evenly spaced sites, each basis and the defaults of version 0.1.0 "
                 "instead, on each --case and --scene (default sites: 500, 1000, 2000, 5000 and 10000)");
    difusa::add_repeated(app, "--beside", a.beside,
                         "what was measured elsewhere, to be shown in the charts of --defaults; those of the same name "
                         "one after the other are joined by a line (may be repeated)",
                         parse_elsewhere)
        ->type_name("NAME=SECONDS,ERROR%");
    app.add_flag("--subdivision", a.subdivision,
                 "what dividing patches of the classical method where the light varies is worth, on each --case and "
                 "--scene (default --sites: 500 to begin with)");
    app.add_flag("--shelf", a.shelf,
                 "shelves of growing length beside the infinite one instead: form factors, patches and bakes");
    app.add_flag("--edges", a.edges,
                 "the light near an edge where two walls meet instead, by their reflectance, and the order of "
                 "convergence of even and graded sites (default --spacing: 0.1, 0.05 and 0.025 of the walls' width; "
                 "default --rays: 16384)");
    app.add_flag("--mirrors", a.mirrors,
                 "form factors over mirror patches instead, in situations with one mirror and with two");

    app.add_flag(
        "--gloss", a.gloss,
        "glossy floors against path tracing instead, by lobe and order of the harmonics (default --sites: 5000)");

    app.add_option("--validation", a.validation,
                   "published validation cases instead: cie-171; --case names them by how they begin, e.g. 5.9")
        ->type_name("NAME");

    app.add_flag("--adaptive", a.plan.common.adaptive, "graded sites: as many as at the spacing, but where they help");
    difusa::add_parsed(app, "--error", a.error,
                       "accuracy requested from each bake of --estimate, as from bake_radiosity", difusa::parse_percent)
        ->type_name("P%");

    const std::string how = "How";
    add_light_arguments(app, a.plan.common, how);
    add_whole<std::size_t>(app, "--places", a.plan.how.places, 1, "surface points at which fields are assessed")
        ->group(how)
        ->type_name("N")
        ->default_str(shown(a.plan.how.places));
    add_whole<std::size_t>(app, "--repeat", a.repeats, 1, "bakes per configuration; the fastest counts")
        ->group(how)
        ->type_name("N")
        ->default_str(shown(a.repeats));
    add_run_arguments(app, a.run, a.plan.common.seed, "errors do not depend");
}

template <class T> void fill(std::vector<T>& values, std::vector<T> standard) {
    if (values.empty()) {
        values = std::move(standard);
    }
}

void study(Arguments& a, const difusa::Registry& registry, const difusa::Execution& execution) {
    fill(a.plan.bases, {"radial", "normalized-radial", "shepard", "moving-least-squares"});
    fill(a.plan.projections, {"natural", "galerkin"});
    fill(a.plan.transports, {"gather"});
    fill(a.plan.rays, {std::size_t{1024}});
    fill(a.plan.final_gathers, {std::size_t{0}});
    a.plan.how.repeats = static_cast<int>(a.repeats);
    const std::vector<difusa::Measurement> measurements =
        difusa::run_study(registry, a.plan, execution, [&](const difusa::Measurement& m) {
            if (!a.run.quiet) {
                difusa::show(m);
            }
        });
    difusa::write_measurements(measurements, a.plan.cases, a.output);
}

/// The options that the plan gives for the bakes of --estimate or --solver: one of each.
difusa::BakeOptions bake_of(const Arguments& a, const std::string& study) {
    const difusa::StudyPlan& plan = a.plan;
    difusa::BakeOptions options = plan.common;
    const auto one = [&](const auto& given, auto& target, const std::string& name) {
        if (given.size() > 1) {
            throw UsageError(study + " takes a single " + name);
        }
        if (!given.empty()) {
            target = given.front();
        }
    };
    one(plan.bases, options.basis, "--basis");
    one(plan.projections, options.projection, "--projection");
    one(plan.transports, options.transport, "--transport");
    one(plan.spacings, options.spacing, "--spacing");
    one(plan.rays, options.rays, "--rays");
    return options;
}

difusa::BakeOptions estimate_options(const Arguments& a) {
    const difusa::StudyPlan& plan = a.plan;
    difusa::BakeOptions options = bake_of(a, "--estimate");
    if (!plan.final_gathers.empty()) {
        throw UsageError("--estimate judges the field as the basis represents it: it does not take --final-gather");
    }
    if (a.error) {
        if (!plan.spacings.empty() || !plan.rays.empty() || plan.common.adaptive) {
            throw UsageError("--error chooses sites and rays itself: omit --spacing, --rays and --adaptive");
        }
        options.target.emplace();
        options.target->relative = *a.error;
    }
    return options;
}

void estimate(const Arguments& a, const difusa::Registry& registry, const difusa::Execution& execution) {
    const bool all = a.plan.cases.empty() && a.scenes.empty();
    difusa::write_estimates(
        {estimate_options(a), a.estimate, all ? difusa::reference_case_names() : a.plan.cases, a.scenes, a.plan.how},
        {a.output, a.run.quiet}, registry, execution);
}

difusa::SolverPlan solver_plan(const Arguments& a) {
    difusa::SolverPlan plan{a.solvers, a.albedos, {1e-2, 1e-6}, bake_of(a, "--solver")};
    fill(plan.albedos, {0.5, 0.9, 0.99});
    if (a.plan.bases.empty()) {
        plan.bake.basis = "normalized-radial"; // whose bounces die out whatever the albedo
    }
    if (a.plan.spacings.empty()) {
        plan.bake.sites = a.sites.value_or(2000);
    } else if (a.sites) {
        throw UsageError("--sites: --spacing says how many there are; omit one of them");
    }
    return plan;
}

/// Refuses the first of the options that is given.
void refuse(const std::string& study, const std::vector<std::pair<bool, std::string>>& options) {
    for (const auto& [given, name] : options) {
        if (given) {
            throw UsageError(study + " does not take " + name);
        }
    }
}

bool compares_methods(const Arguments& a) {
    return a.side_by_side || a.subdivision || a.defaults;
}

/// What --side-by-side, --defaults and --subdivision do not take.
void check_side_by_side(const Arguments& a) {
    if (!a.beside.empty() && !a.defaults) {
        throw UsageError("--beside is for the charts of --defaults");
    }
    if (!compares_methods(a)) {
        return;
    }
    const std::string study = a.side_by_side ? "--side-by-side" : a.defaults ? "--defaults" : "--subdivision";
    const difusa::StudyPlan& plan = a.plan;
    const std::vector<std::pair<bool, std::string>> given{
        {!plan.bases.empty(), "--basis"},
        {!plan.projections.empty(), "--projection"},
        {!plan.transports.empty(), "--transport"},
        {!plan.spacings.empty(), "--spacing"},
        {!plan.final_gathers.empty(), "--final-gather"},
        {plan.common.adaptive, "--adaptive"},
        {!a.validation.empty(), "--validation"},
        {!a.solvers.empty(), "--solver"},
        {!a.albedos.empty(), "--albedo"},
        {a.chapter7, "--chapter7"},
        {a.estimate > 0, "--estimate"},
        {a.repeats > 1, "--repeat"},
        {a.error.has_value(), "--error"},
        {a.side_by_side && a.defaults, "--defaults"},
        {(a.side_by_side || a.defaults) && a.subdivision, "--subdivision"}};
    refuse(study, given);
    if (a.plan.rays.size() > 1) {
        throw UsageError(study + " takes a single --rays");
    }
    if (a.plan.cases.empty() && a.scenes.empty()) {
        throw UsageError(study + " needs a --case or a --scene");
    }
}

void side_by_side(const Arguments& a, const difusa::Registry& registry, const difusa::Execution& execution) {
    difusa::SideBySide plan;
    plan.common = a.plan.common;
    plan.common.rays = a.plan.rays.empty() ? plan.common.rays : a.plan.rays.front();
    plan.sites = a.sites         ? std::vector<std::size_t>{*a.sites}
                 : a.subdivision ? std::vector<std::size_t>{500}
                 : a.defaults    ? std::vector<std::size_t>{500, 1000, 2000, 5000, 10000}
                                 : std::vector<std::size_t>{500, 2000};
    plan.elsewhere = a.beside;
    plan.cases = a.plan.cases;
    plan.scenes = a.scenes;
    plan.how = a.plan.how;
    const auto write = a.subdivision ? difusa::write_subdivision
                       : a.defaults  ? difusa::write_defaults
                                     : difusa::write_side_by_side;
    write(plan, {a.output, a.run.quiet}, registry, execution);
}

/// What --validation does not take.
void check_validation(const Arguments& a) {
    if (a.validation.empty()) {
        return;
    }
    if (a.validation != "cie-171") {
        throw UsageError("--validation " + a.validation + ": unknown, must be cie-171");
    }
    const std::vector<std::pair<bool, std::string>> given{
        {!a.scenes.empty(), "--scene"}, {!a.solvers.empty(), "--solver"}, {a.chapter7, "--chapter7"},
        {a.estimate > 0, "--estimate"}, {a.repeats > 1, "--repeat"},      {a.error.has_value(), "--error"}};
    refuse("--validation", given);
}

difusa::BakeOptions validation_options(const Arguments& a) {
    difusa::BakeOptions options = bake_of(a, "--validation");
    if (a.plan.final_gathers.size() > 1) {
        throw UsageError("--validation takes a single --final-gather");
    }
    options.final_gather = a.plan.final_gathers.empty() ? 0 : a.plan.final_gathers.front();
    return options;
}

bool has_places(const Arguments& a) {
    return a.plan.how.places != difusa::MeasureOptions{}.places;
}

/// What --mirrors, --shelf, --edges and --gloss do not take.
void check_mirrors(const Arguments& a) {
    if (!a.mirrors && !a.shelf && !a.edges && !a.gloss) {
        return;
    }
    const std::string study = a.mirrors ? "--mirrors" : a.shelf ? "--shelf" : a.edges ? "--edges" : "--gloss";
    const std::vector<std::pair<bool, std::string>> given{
        {!a.plan.cases.empty(), "--case"},
        {!a.plan.bases.empty(), "--basis"},
        {!a.plan.projections.empty(), "--projection"},
        {!a.plan.transports.empty(), "--transport"},
        {!a.edges && !a.plan.rays.empty(), "--rays"},
        {a.plan.rays.size() > 1, "a second --rays"},
        {!a.plan.final_gathers.empty(), "--final-gather"},
        {!a.scenes.empty(), "--scene"},
        {!a.solvers.empty(), "--solver"},
        {!a.validation.empty(), "--validation"},
        {a.side_by_side, "--side-by-side"},
        {a.defaults, "--defaults"},
        {a.subdivision, "--subdivision"},
        {a.chapter7, "--chapter7"},
        {a.estimate > 0, "--estimate"},
        {a.repeats > 1, "--repeat"},
        {a.mirrors && a.shelf, "--shelf"},
        {a.edges && (a.mirrors || a.shelf), "--edges"},
        {a.gloss && (a.mirrors || a.shelf || a.edges), "--gloss"},
        {!a.shelf && a.plan.common.adaptive, "--adaptive"},
        {a.edges && std::set(a.plan.spacings.begin(), a.plan.spacings.end()).size() < a.plan.spacings.size(),
         "a --spacing twice"},
        {(a.mirrors || a.gloss) && has_places(a), "--places"},
        {(a.mirrors || a.gloss) && a.plan.common.direct != difusa::BakeOptions{}.direct, "--direct"},
        {(a.mirrors || a.gloss) && a.plan.common.kernel != difusa::BakeOptions{}.kernel, "--kernel"},
        {a.gloss && !a.plan.spacings.empty(), "--spacing"},
        {!a.edges && a.plan.spacings.size() > 1, "a second --spacing"},
        {a.edges && a.plan.spacings.size() == 1, "a single --spacing"}};
    refuse(study, given);
}

void judge_mirrors(const Arguments& a, const difusa::Registry& registry, const difusa::Execution& execution) {
    const double spacing = a.plan.spacings.empty() ? 0.1 : a.plan.spacings.front();
    difusa::write_mirrors(spacing, a.plan.common.seed, {a.output, a.run.quiet}, registry, execution);
}

void measure_shelves(const Arguments& a, const difusa::Registry& registry, const difusa::Execution& execution) {
    difusa::BakeOptions options = a.plan.common;
    options.spacing = a.plan.spacings.empty() ? 0.1 : a.plan.spacings.front();
    difusa::write_shelves(options, a.plan.how, {a.output, a.run.quiet}, registry, execution);
}

void measure_edges(const Arguments& a, const difusa::Registry& registry, const difusa::Execution& execution) {
    const std::vector<double> spacings =
        a.plan.spacings.empty() ? std::vector<double>{0.1, 0.05, 0.025} : a.plan.spacings;
    difusa::BakeOptions options = a.plan.common;
    options.rays = a.plan.rays.empty() ? 16384 : a.plan.rays.front();
    difusa::write_edges(options, spacings, a.plan.how, {a.output, a.run.quiet}, registry, execution);
}

/// What --solver needs, and does not take.
void check_solvers(const Arguments& a, const difusa::Registry& registry) {
    if (a.solvers.empty() && (!a.albedos.empty() || (a.sites && !compares_methods(a) && !a.gloss))) {
        throw UsageError(
            "--albedo and --sites are for the comparison of solvers (name them, --solver krylov --solver "
            "jacobi), and --sites for --side-by-side, --defaults, --subdivision and --gloss: omit them, or "
            "give --spacing");
    }
    if (a.solvers.empty()) {
        return;
    }
    for (const std::string& solver : a.solvers) {
        registry.describe("solver", solver);
    }
    if (a.scenes.empty()) {
        throw UsageError("--solver: needs a scene whose system is to be solved, --scene data/room_a.json");
    }
    const std::vector<std::pair<bool, std::string>> given{
        {!a.plan.cases.empty(), "--case"}, {!a.plan.final_gathers.empty(), "--final-gather"},
        {a.repeats > 1, "--repeat"},       {has_places(a), "--places"},
        {a.chapter7, "--chapter7"},        {a.estimate > 0, "--estimate"}};
    refuse("--solver", given);
}

/// Chapter 7 has its own scene, transports and error measure.
void refuse_for_chapter7(const Arguments& a) {
    const std::vector<std::pair<bool, std::string>> given{{!a.plan.cases.empty(), "--case"},
                                                          {!a.plan.projections.empty(), "--projection"},
                                                          {!a.plan.transports.empty(), "--transport"},
                                                          {!a.plan.final_gathers.empty(), "--final-gather"},
                                                          {a.repeats > 1, "--repeat"},
                                                          {has_places(a), "--places"},
                                                          {a.plan.rays.size() > 1, "a second --rays"}};
    refuse("--chapter7", given);
}

void chapter7(Arguments& a, const difusa::Registry& registry, const difusa::Execution& execution) {
    fill(a.plan.bases, {"radial", "normalized-radial", "shepard"});
    fill(a.plan.spacings, {3.0, 1.0});
    fill(a.plan.rays, {std::size_t{1024}});
    difusa::write_chapter7(a.plan, {a.output, a.run.quiet}, registry, execution);
}

/// Wrong options and names are rejected before anything is printed or written.
void check(const Arguments& a, const difusa::Registry& registry) {
    check_validation(a);
    check_mirrors(a);
    for (const std::string& name : a.plan.cases) {
        if (a.validation.empty()) {
            difusa::require_reference_case(name);
        }
    }
    for (const std::string& basis : a.plan.bases) {
        registry.describe("basis", basis);
    }
    if (a.chapter7) {
        refuse_for_chapter7(a);
    }
    check_side_by_side(a);
    check_solvers(a, registry);
    difusa::check_chart_names(a.plan.cases, a.scenes);
    if (!a.scenes.empty() && a.estimate == 0 && a.solvers.empty() && !compares_methods(a)) {
        throw UsageError("--scene is for --estimate, --solver, --side-by-side, --defaults and --subdivision only: "
                         "other studies need a known solution (--case)");
    }
    if (a.error && a.estimate == 0) {
        throw UsageError("--error is for the bakes of --estimate");
    }
    if (a.estimate > 0 && (a.chapter7 || a.repeats > 1)) {
        throw UsageError("--estimate does not take --chapter7 or --repeat");
    }
    std::vector<std::string> notes; // collected from the bakes
    difusa::choose_visibility(registry, a.plan.common.visibility, notes);
    std::string text;
    for (const std::string& projection : a.plan.projections) {
        difusa::parse_projection(projection, text);
    }
    if (!a.validation.empty()) {
        validation_options(a);
        difusa::cie_171_cases(a.plan.cases);
    } else if (!a.solvers.empty()) {
        solver_plan(a);
    } else if (a.estimate > 0) {
        estimate_options(a);
    }
    for (const std::string& scene : a.scenes) {
        difusa::check_readable(scene);
    }
}

void run(Arguments& a) {
    if (a.output.empty()) {
        throw UsageError("a directory for the results is expected: measure_accuracy --output study (--help)");
    }
    const difusa::Registry registry = difusa::Registry::load(a.run.plugin_path);
    check(a, registry);
    a.plan.how.seed = a.plan.common.seed;
    std::error_code error;
    std::filesystem::create_directories(a.output, error);
    if (error) {
        throw difusa::ResourceError(a.output.string() + ": cannot be created: " + error.message());
    }
    difusa::check_output_path(a.output / "measurements.csv", false);
    difusa::TerminalProgress progress(true); // interruptible; the measurements show the progress
    const difusa::Execution execution = a.run.execution(progress);
    if (a.mirrors) {
        judge_mirrors(a, registry, execution);
    } else if (a.gloss) {
        difusa::write_gloss(a.sites.value_or(difusa::default_sites), a.plan.common.seed, {a.output, a.run.quiet},
                            registry, execution);
    } else if (a.shelf) {
        measure_shelves(a, registry, execution);
    } else if (a.edges) {
        measure_edges(a, registry, execution);
    } else if (!a.validation.empty()) {
        difusa::write_validation(difusa::cie_171_cases(a.plan.cases), validation_options(a), {a.output, a.run.quiet},
                                 registry, execution);
    } else if (compares_methods(a)) {
        side_by_side(a, registry, execution);
    } else if (a.chapter7) {
        chapter7(a, registry, execution);
    } else if (!a.solvers.empty()) {
        difusa::write_solvers(solver_plan(a), a.scenes, {a.output, a.run.quiet}, registry, execution);
    } else if (a.estimate > 0) {
        estimate(a, registry, execution);
    } else {
        study(a, registry, execution);
    }
    if (!a.run.quiet) {
        std::cout << "written: " << a.output.string() << std::endl;
    }
}

int program(int count, char** words) {
    std::string text = examples, cases;
    for (const difusa::ReferenceCaseName& one : difusa::reference_cases()) {
        cases.append("\n  ").append(one.name).append(": ").append(one.about);
    }
    text.replace(text.find("%CASES%"), 7, cases);
    CLI::App app(text, "measure_accuracy");
    Arguments arguments;
    declare(app, arguments);
    return difusa::run_command(app, count, words, "no arguments but options", arguments.run.version,
                               [&] { run(arguments); });
}

} // namespace measure_accuracy
