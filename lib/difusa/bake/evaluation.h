// The field of a bake at the points where its light is wanted, and its error there.
#pragma once

#include <difusa/bake/result.h>

namespace difusa {

/// Throws ResourceError if the output mesh is sure to have more triangles than memory allows.
void check_output(const BakeResult& result, const Execution& execution);

/// Fills in `error`, measured at random surface points. Phase "estimate error".
void estimate_error_of(BakeResult& result, const Execution& execution);

/// Fills in `goal_estimates`, unless they are there. Phase "estimate goals", if there are any.
void estimate_goals_of(BakeResult& result, const Execution& execution);

/// Fills in `mesh`. Phase "refine output".
void refine_output(BakeResult& result, const Execution& execution);

/// Fills in `output` and what else the options request: centres, errors, the light at places (bake/sensing.h). Phase
/// "evaluate".
void evaluate_output(BakeResult& result, const Execution& execution);

/// Records what this scene did not need.
void list_savings(const BakeResult& result, const Execution& execution);

} // namespace difusa
