#include <difusa/bake/choices.h>

#include <difusa/core/error.h>
#include <difusa/plugin/choice.h>
#include <difusa/rays/visibility_choice.h>

namespace difusa {

Choices make_choices(const Registry& registry, const BakeOptions& options) {
    check_options(options);
    Choices choices;
    const auto make = [&]<class T>(std::shared_ptr<T>& object, const std::string& choice) {
        object = registry.create<T>(choice);
        choices.plugins.emplace_back(kind_of<T>(), registry.describe(kind_of<T>(), choice));
    };
    const ParameterSpec areas{"areas",
                              ParameterSpec::Type::word,
                              "integral",
                              "effective areas: integrals of the basis functions (T 5.3), or from neighbours (T 5.5)",
                              0,
                              0,
                              {"integral", "neighbours"}};
    const Choice transport = parse_choice("transport", options.transport, {{"gather", {}}, {"pairwise", {areas}}});
    choices.pairwise = transport.name == "pairwise";
    choices.neighbour_areas = choices.pairwise && transport.parameters.word("areas") == "neighbours";
    choices.plugins.emplace_back("transport", transport.text());
    choices.direct_in_basis =
        parse_choice("direct", options.direct, {{"exact", {}}, {"interpolated", {}}}).name == "interpolated";

    make(choices.sampler, options.sampler);
    make(choices.basis, options.basis);
    choices.visibility = choose_visibility(registry, options.visibility, choices.notes);
    make(choices.engine, choices.visibility);
    make(choices.directions, options.directions);
    make(choices.solver, options.solver);
    if (choices.pairwise) {
        make(choices.kernel, options.kernel.empty() ? "disc" : options.kernel);
    } else if (!options.kernel.empty()) {
        registry.describe("kernel", options.kernel); // a wrong name is reported first
        throw UsageError("--kernel " + options.kernel +
                         ": rays need no form-factor kernel; omit it, or use "
                         "--transport pairwise");
    }
    std::string projection;
    choices.projection = projection_for(*choices.basis, options.projection, projection);
    choices.plugins.emplace_back("projection", projection);
    if (choices.pairwise && (choices.projection.kind == ProjectionKind::least_squares ||
                             choices.projection.kind == ProjectionKind::galerkin)) {
        throw UsageError("--projection " + options.projection +
                         ": needs light at more points than the sites, which pairwise transport does not compute; use "
                         "--transport gather, or another projection");
    }
    return choices;
}

} // namespace difusa
