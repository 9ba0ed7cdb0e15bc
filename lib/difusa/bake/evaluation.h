// The field of a bake at the points where its light is wanted, and its error there.
#pragma once

#include <difusa/bake/result.h>

namespace difusa {

/// Fills in `error`: the residual of the field at random surface points. Phase "estimate error".
void estimate_error_of(BakeResult& result, const Execution& execution);

/// Fills in `mesh`, `output` and what else the options request: centres, listed, residual, error_bound. Phases "refine
/// output", "evaluate". Throws InputError for a listed point whose normal matches no surface.
void evaluate_output(BakeResult& result, const Execution& execution);

/// Records what this scene did not need.
void list_savings(const BakeResult& result, const Execution& execution);

} // namespace difusa
