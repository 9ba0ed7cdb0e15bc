// Sites where they help: as many as asked for, dense where the light varies from one site to the next.
#pragma once

#include <difusa/bake/placing.h>
#include <difusa/plugin/registry.h>

#include <optional>

namespace difusa {

/// The share of the sites that the pilots take together.
inline constexpr double pilot_sites = 0.75;

/// As many sites as `place_sites` would place, graded by pilot bakes of the lights that the scene has: a quarter of the
/// sites, evenly spaced, and then half of them, graded. How far a pilot's light at a site differs from what the other
/// sites predict (discretisation/grading.h), reflected, is the size of the error there. The sampler must cover the
/// whole surface. Nothing if most of the sites are needed for one on each region, so that hardly any are left to grade;
/// or if the errors of the first pilot vary so little that grading would not halve the squared error (noted as a
/// saving). Phases "place sites", "pilot bake". Throws what a bake does.
std::optional<Placed> place_adaptively(BakeResult& result, const Registry& registry, const Choices& choices,
                                       const LitSurface& lit, const Tracer& tracer, const Execution& execution);

} // namespace difusa
