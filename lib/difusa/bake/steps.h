// The steps that a bake from nothing (bake.h) and one with a saved transport (bake/relight.h) have in common.
#pragma once

#include <difusa/bake/choices.h>
#include <difusa/bake/placing.h>
#include <difusa/bake/result.h>
#include <difusa/lighting/direct_light.h>
#include <difusa/rays/tracer.h>

#include <functional>
#include <memory>

namespace difusa {

using BakeSteps = std::function<void(BakeResult& result, Choices& choices, const Execution& execution)>;

/// Makes the choices of the options, and runs `steps` on a result with a journal of its own, which is appended to the
/// caller's in any case.
BakeResult run_steps(const Registry& registry, const BakeOptions& options, const Execution& execution,
                     const BakeSteps& steps);

/// Refuses outputs, places and goals that may be refused before time is spent, and finds where they are. The spacing
/// has been chosen.
void check_request(BakeResult& result, const Execution& execution);

/// Where the transport of a discretisation comes from.
using TransportSource = std::function<LightTransport(const Discretisation& discretisation, const Execution& execution)>;

/// The transport computed by rays, or by pairs, in the phase "transport".
TransportSource transport_by_rays(const BakeResult& result, const Choices& choices, const Tracer& tracer);

/// How the scene of the result is to be lit.
LightingOptions lighting_options(const BakeResult& result, const Choices& choices);

/// Makes system and solution, with the second choice of elements, which share the transport, if bounces do not die out
/// with the first.
void solve_placed(BakeResult& result, const Choices& choices, const Placed& placed, const TransportSource& transport,
                  const Execution& execution);

/// Estimates goals, and evaluates the field at the vertices of the output and at the places of the options.
void evaluate_solution(BakeResult& result, const Execution& execution);

/// The same for another solution, with the output mesh that is there.
void evaluate_anew(BakeResult& result, const Execution& execution);

} // namespace difusa
