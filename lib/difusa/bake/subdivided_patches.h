// The classical method's adaptive subdivision (L 31): patches are divided into elements where the light varies.
#pragma once

#include <difusa/bake/placing.h>
#include <difusa/plugin/registry.h>

#include <memory>

namespace difusa {

/// Sites at the centres of the elements: no more than BakeOptions::sites, or than the patches with BakeOptions::spacing
/// would be, for the spacing that has been chosen (`choose_spacing`). The patches have edges twice as long, which makes
/// them a quarter as many. Pilot bakes with a part of the rays (bake/pilot.h) on these, and on elements as many as the
/// geometric mean of both numbers, tell how much of the reflected light a constant on each element misses
/// (discretisation/subdivision.h): the worst elements are quartered. What misses less than a millionth of the rms of
/// that light is left whole, so that constant light divides nothing. Phases "pilot bake", "place sites"; throws what a
/// bake does.
Placed place_elements(const BakeResult& result, const Registry& registry, const Choices& choices, const LitSurface& lit,
                      const Tracer& tracer, const Execution& execution);

} // namespace difusa
