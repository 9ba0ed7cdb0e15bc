// Sites for lit places that are out of sight of all others: pockets between parts, surfaces that others cut off.
#pragma once

#include <difusa/bake/choices.h>
#include <difusa/bake/placing.h>
#include <difusa/bake/result.h>
#include <difusa/discretisation/site_set.h>
#include <difusa/plugin/registry.h>
#include <difusa/rays/tracer.h>

#include <functional>
#include <memory>
#include <vector>

namespace difusa {

/// Adds sites to `sites` where light can arrive, but no element does, because no site of the region is in sight
/// (PointBasis::reaches): such places would be black, and send nothing back. Eight places for each site are examined,
/// evenly spread over the lit surface, and as many others while more than one in a thousand is found; where rays meet
/// nothing but backs, no light arrives. What is added is half of the spacing apart, or of that of as many sites on one
/// plane, in a few rounds, until nothing is missing or there are twice as many sites, or as many as the options allow;
/// their number is noted. `remake` makes a site set of points, in any order, with radii of at least `spacing`.
///
/// Returns `sites` themselves if nothing is missing, with a basis that is bound to them; or without one if the elements
/// are of another kind, or the sampler is meant to leave surface without sites.
Placed with_sites_in_sight(
    const BakeResult& result, const Registry& registry, const Choices& choices, const LitSurface& lit,
    const Tracer& tracer, std::shared_ptr<SiteSet> sites, const Execution& execution,
    const std::function<std::shared_ptr<SiteSet>(std::vector<SurfacePoint> points, double spacing)>& remake);

} // namespace difusa
