// The field of a bake at the places where its light is wanted, and how wrong it is there.
#pragma once

#include <difusa/bake/result.h>

namespace difusa {

/// Fills in `listed` and `listed_distance`. Throws InputError for a listed place whose normal no surface has.
void find_listed(BakeResult& result, const Execution& execution);

/// Throws ResourceError if the output mesh is sure to have more triangles than memory allows.
void check_output(const BakeResult& result);

/// Fills in `error`: the residual of the field at random surface points. Phase "estimate error".
void estimate_error_of(BakeResult& result, const Execution& execution);

/// Fills in `mesh`, `output` and what the options ask for besides: centres, listed_values, residual, error_bound.
/// Phases "refine output", "evaluate".
void evaluate_output(BakeResult& result, const Execution& execution);

/// Writes down what this scene did not need.
void list_savings(const BakeResult& result, const Execution& execution);

} // namespace difusa
