#include <difusa/bake/choices.h>

#include <difusa/core/error.h>
#include <difusa/plugin/choice.h>
#include <difusa/rays/visibility_choice.h>

namespace difusa {

namespace {

ElementChoice make_elements(const Registry& registry, const std::string& basis, const BakeOptions& options) {
    ElementChoice elements;
    elements.basis = registry.create<Basis>(basis);
    elements.basis_text = registry.describe("basis", basis);
    elements.projection = projection_for(*elements.basis, options.projection, elements.projection_text,
                                         is_subdivided(*elements.basis, options));
    return elements;
}

/// Throws UsageError if the solver relaxes single unknowns, and all coefficients follow from all values.
void check_solver(const Solver& solver, const std::string& choice, const ElementChoice& elements) {
    if (solver.needs_factors() && !is_local(elements.projection, *elements.basis)) {
        throw UsageError("--solver " + choice + ": relaxes one unknown after the other, but with --basis " +
                         elements.basis_text + " and --projection " + elements.projection_text +
                         " all coefficients follow from all values; use --solver krylov or jacobi, or --projection "
                         "natural or corrected:in=equation with a basis that allows it");
    }
}

/// Throws UsageError for what concerns elements into which patches are divided.
void check_subdivision(const Choices& choices, const BakeOptions& options) {
    const bool subdivided = is_subdivided(*choices.elements.basis, options);
    if (options.levels && !subdivided) {
        throw UsageError("--levels: limits how finely patches are divided, and none is here; add --adaptive to --basis "
                         "patch-constant, or omit it");
    }
    if (subdivided && choices.pairwise) {
        throw UsageError("--adaptive: the elements into which patches are divided gather light by rays from larger "
                         "ones, which --transport pairwise does not; use --transport gather");
    }
}

/// Throws UsageError if sites are to be added where they help, and neither the sampler nor the basis can do that.
void check_grading(const Sampler& sampler, const std::string& name, const Basis& basis, const BakeOptions& options) {
    if (is_subdivided(basis, options)) {
        return;
    }
    if (options.adaptive && sampler.needs_visibility()) {
        throw UsageError("--adaptive: adds sites to ones that cover the whole surface evenly, which --sampler " + name +
                         " does not place; omit one of them");
    }
    if (!sampler.can_be_graded() && (options.adaptive || options.target)) {
        throw UsageError(std::string(options.target ? "--error" : "--adaptive") +
                         ": adds sites where they help, but those of --sampler " + name +
                         " belong to an even mesh; use a basis that any sites will do for, such as normalized-radial" +
                         (options.target ? "" : ", or patch-constant, shown flat, whose patches are then divided"));
    }
}

/// Throws UsageError if an accuracy is ordered and no more rays can be had from these directions, or would not tell.
void check_directions(const Directions& directions, const BakeOptions& options) {
    if (!options.target) {
        return;
    }
    if (directions.size(1) == directions.size(std::size_t{1} << 20U)) {
        throw UsageError("--error: adds rays, but --directions " + options.directions +
                         " states their number; omit its resolution");
    }
    if (directions.is_fixed()) {
        throw UsageError("--error: the errors of --directions " + options.directions +
                         " repeat from site to site, so that nothing tells whether more rays are needed; use a random "
                         "grid");
    }
}

Choice choose_transport(const std::string& text) {
    using Type = ParameterSpec::Type;
    const std::vector<ParameterSpec> pairwise{
        {"areas",
         Type::word,
         "integral",
         "effective areas: integrals of the basis functions (T 5.3), or from neighbours (T 5.5)",
         0,
         0,
         {"integral", "neighbours"}},
        {"mirrors",
         Type::word,
         "gathered",
         "paths over mirror patches: from receivers, from emitters, or from these with the factors of M as printed",
         0,
         0,
         {"gathered", "shot", "printed"}},
        {"granularity", Type::real, "1", "longest edge of mirror patches, in spacings of the sites", 0.01, 1000, {}},
        {"adaptive",
         Type::word,
         "yes",
         "whether mirror patches are quartered until they cover no more than that at the farthest surface they show",
         0,
         0,
         {"yes", "no"}}};
    return parse_choice("transport", text, {{"gather", {}}, {"pairwise", pairwise}});
}

constexpr const char *sure_basis = "normalized-radial", *accurate_basis = "moving-least-squares";

std::string basis_of(const BakeOptions& options, bool pairwise) {
    return !options.basis.empty() ? options.basis : pairwise ? sure_basis : accurate_basis;
}

MirrorPathOptions mirror_paths(const Parameters& parameters) {
    MirrorPathOptions options;
    const std::string& paths = parameters.word("mirrors");
    options.paths = paths == "gathered" ? MirrorPaths::gathered
                    : paths == "shot"   ? MirrorPaths::shot
                                        : MirrorPaths::printed;
    options.granularity = parameters.real("granularity");
    options.adaptive = parameters.word("adaptive") == "yes";
    return options;
}

/// Once the other choices are made.
AnalyticUse choose_analytic(const Choices& choices, const BakeOptions& options) {
    const std::string name =
        parse_choice("analytic", options.analytic, {{"auto", {}}, {"always", {}}, {"never", {}}}).name;
    const bool possible = !choices.pairwise && !choices.solver->needs_factors() && choices.directions->equal_weights();
    if (name == "always" && !possible) {
        throw UsageError(
            "--analytic always: exact form factors complement rays of equal weight, and are not for solvers that relax "
            "single unknowns: use --transport gather, --solver krylov or jacobi, and other --directions");
    }
    return !possible || name == "never" ? AnalyticUse::never
           : name == "always"           ? AnalyticUse::always
                                        : AnalyticUse::automatic;
}

} // namespace

bool is_subdivided(const Basis& basis, const BakeOptions& options) {
    return options.adaptive && !options.target && basis.can_be_subdivided();
}

std::string fitting_sampler(const std::string& chosen, const std::string& basis_choice, const Basis& basis) {
    const std::string demanded = basis.sampler();
    if (chosen.empty()) {
        return demanded.empty() ? "poisson-disk" : demanded;
    }
    if (!demanded.empty() && chosen.substr(0, chosen.find(':')) != demanded) {
        throw UsageError("--basis " + basis_choice + ": its elements belong to the sites of --sampler " + demanded +
                         ", not to those of " + chosen + "; omit --sampler, or choose another basis");
    }
    return chosen;
}

bool can_be_graded(const Registry& registry, const BakeOptions& options) {
    if (choose_transport(options.transport).name == "pairwise") {
        return false;
    }
    const std::string choice = basis_of(options, false);
    const std::shared_ptr<Basis> basis = registry.create<Basis>(choice);
    const std::shared_ptr<Sampler> sampler = registry.create<Sampler>(fitting_sampler(options.sampler, choice, *basis));
    return !basis->can_be_subdivided() && sampler->covers_evenly();
}

Choices make_choices(const Registry& registry, const BakeOptions& options) {
    check_options(options);
    Choices choices;
    const auto make = [&]<class T>(std::shared_ptr<T>& object, const std::string& choice) {
        object = registry.create<T>(choice);
        choices.plugins.emplace_back(kind_of<T>(), registry.describe(kind_of<T>(), choice));
    };
    const Choice transport = choose_transport(options.transport);
    choices.pairwise = transport.name == "pairwise";
    if (choices.pairwise) {
        choices.neighbour_areas = transport.parameters.word("areas") == "neighbours";
        choices.over_mirrors = mirror_paths(transport.parameters);
    }
    choices.plugins.emplace_back("transport", transport.text());
    choices.direct_in_basis =
        parse_choice("direct", options.direct, {{"exact", {}}, {"interpolated", {}}}).name == "interpolated";
    choices.operator_bounce =
        parse_choice("first-bounce", options.first_bounce, {{"live", {}}, {"operator", {}}}).name == "operator";
    choices.stop_by_change = parse_choice("stop", options.stop, {{"residual", {}}, {"change", {}}}).name == "change";
    choices.sensor = parse_choice("sensor", options.sensor,
                                  {{"planar", {}}, {"horizontal", {}}, {"spherical", {}}, {"cylindrical", {}}})
                         .name;
    parse_choice("units", options.units, {{"auto", {}}, {"radiometric", {}}, {"photometric", {}}});
    const std::string flip = parse_choice("flip", options.flip, {{"auto", {}}, {"all", {}}, {"none", {}}}).name;
    choices.flip = flip == "all" ? Flip::all : flip == "none" ? Flip::nothing : Flip::certain;

    const std::string basis = basis_of(options, choices.pairwise);
    choices.elements = make_elements(registry, basis, options);
    if (options.basis.empty() && !choices.pairwise) {
        choices.fallback = make_elements(registry, sure_basis, options);
    }
    choices.sampler_name = fitting_sampler(options.sampler, basis, *choices.elements.basis);
    make(choices.sampler, choices.sampler_name);
    check_subdivision(choices, options);
    check_grading(*choices.sampler, choices.sampler_name, *choices.elements.basis, options);
    choices.visibility = choose_visibility(registry, options.visibility, choices.notes);
    make(choices.engine, choices.visibility);
    make(choices.directions, options.directions);
    check_directions(*choices.directions, options);
    choices.fresh_directions =
        choices.directions->is_fixed() ? registry.create<Directions>(BakeOptions{}.directions) : choices.directions;
    make(choices.solver, options.solver);
    check_solver(*choices.solver, options.solver, choices.elements);
    if (choices.fallback) {
        check_solver(*choices.solver, options.solver, *choices.fallback);
    }
    if (choices.pairwise) {
        make(choices.kernel, options.kernel.empty() ? "disc" : options.kernel);
    } else if (!options.kernel.empty()) {
        registry.describe("kernel", options.kernel); // a wrong name is reported first
        throw UsageError("--kernel " + options.kernel +
                         ": rays need no form-factor kernel; omit it, or use "
                         "--transport pairwise");
    }
    const ProjectionKind projection = choices.elements.projection.kind;
    if (choices.pairwise && (projection == ProjectionKind::least_squares || projection == ProjectionKind::galerkin)) {
        throw UsageError("--projection " + options.projection +
                         ": needs light at more points than the sites, which pairwise transport does not compute; use "
                         "--transport gather, or another projection");
    }
    choices.analytic = choose_analytic(choices, options);
    choices.aims_at_openings = !choices.pairwise && !choices.solver->needs_factors() &&
                               choices.directions->equal_weights() && !choices.directions->is_fixed();
    return choices;
}

} // namespace difusa
