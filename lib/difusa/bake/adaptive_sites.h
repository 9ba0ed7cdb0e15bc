// Sites where they help: as many as asked for, dense where the light varies from one site to the next.
#pragma once

#include <difusa/bake/placing.h>
#include <difusa/plugin/registry.h>

#include <memory>

namespace difusa {

/// What the pilots take, of the rays and of the points and surfels of the bake.
inline constexpr double pilot_rays = 0.1875, pilot_sites = 0.75;

/// As many sites as `place_sites` would place, graded by pilot bakes of the lights that the scene has: a sixteenth of
/// the sites, evenly spaced, and then a quarter, graded, each with fewer rays. What a pilot's light at a site differs
/// from what the other sites say of it (discretisation/grading.h), reflected, is the size of the error there. Phases of
/// the pilots, and "place sites". Throws what a bake does.
std::shared_ptr<SiteSet> place_adaptively(BakeResult& result, const Registry& registry, const Choices& choices,
                                          const LitSurface& lit, const Tracer& tracer, const Execution& execution);

} // namespace difusa
