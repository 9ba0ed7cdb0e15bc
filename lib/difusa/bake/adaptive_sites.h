// Sites where they help: as many as asked for, dense where the light varies from one site to the next.
#pragma once

#include <difusa/bake/placing.h>
#include <difusa/plugin/registry.h>

#include <memory>
#include <optional>
#include <vector>

namespace difusa {

/// The share of the sites that the pilots take together.
inline constexpr double pilot_sites = 0.75;

/// What a bake tells another one of the same scene: the spacing around each of its sites, and the size of the error
/// there, W/m² (#sites).
struct Judged {
    std::shared_ptr<const SiteSet> sites;
    std::vector<double> spacing, error;
    double relative = 0.0; ///< root mean square of the error over that of the light
};

/// From a solution on `placed`; of the elements and the transport that pilots have. Nothing from others.
std::optional<Judged> judged_by(const BakeResult& result, const Placed& placed, const Execution& execution);

/// As many sites as `place_sites` would place, for the spacing that has been chosen (`choose_spacing`), graded by pilot
/// bakes of the lights that the scene has: a quarter of the sites, evenly spaced, and then half of them, graded. How
/// far a pilot's light at a site differs from what the other sites predict (discretisation/grading.h), reflected, is
/// the size of the error there. `known`: an earlier bake, which stands in for the first pilot if it has at least an
/// eighth of the sites, and for both if it has a third. The sampler must cover the whole surface. Nothing if most of
/// the sites are needed for one on each region, so that hardly any are left to grade; or if the errors at evenly spaced
/// sites vary so little that grading would not halve the squared error, or are less than 2^-12 of the light (noted as a
/// saving). Phases "pilot bake", "place sites". Throws what a bake does.
std::optional<Placed> place_adaptively(const BakeResult& result, const Registry& registry, const Choices& choices,
                                       const LitSurface& lit, const Tracer& tracer, const std::optional<Judged>& known,
                                       const Execution& execution);

} // namespace difusa
