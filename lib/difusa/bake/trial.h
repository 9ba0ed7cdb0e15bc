// The time of a bake, predicted from a smaller one.
#pragma once

#include <difusa/bake/choices.h>
#include <difusa/bake/placing.h>
#include <difusa/bake/result.h>
#include <difusa/rays/tracer.h>

#include <functional>

namespace difusa {

/// Places sites, solves and estimates the error, as the bake does.
using SolveSteps = std::function<void(BakeResult& attempt, Choices& choices, const Execution& execution)>;

/// Fills in BakeEstimate::phases: bakes the scene with a tenth of the sites, 300 to 2000, at a spacing that is wider
/// accordingly, and multiplies the time of each phase with what its work grows by. Exact form factors are timed at a
/// few points, with the surfels and rays of the bake. The smaller bake has at most 2^20 rays to cast for its transport,
/// and 64 for each point of a final gather. `result`: its request is checked, its spacing chosen. Fills in no phases,
/// and notes why, if the smaller bake fails. Phase "trial bake".
///
/// Fills in BakeEstimate::peak_bytes too: what the process held at most up to the end of the smaller bake, with the
/// same mesh and trees, and by how much more is estimated for the bake than for the smaller one.
void predict_time(BakeResult& result, const Registry& registry, const Choices& choices, const SolveSteps& solve,
                  const Execution& execution);

} // namespace difusa
