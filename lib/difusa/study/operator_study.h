// Forms of the rendering operator against the iteration: error, time and memory for the lights of a scene.
#pragma once

#include <difusa/bake/result.h>
#include <difusa/radiosity/rendering_operator.h>

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace difusa {

/// One light group under one operator. Errors are rms over the area, relative to the rms of the solution; times are
/// processor times of all threads.
struct OperatorTrial {
    std::string choice, light;
    std::size_t points = 0;
    double stated = 0.0;            ///< RenderingOperator::apply
    double measured = 0.0;          ///< against the iteration
    double prepare_seconds = 0.0;   ///< to form the operator
    double seconds = 0.0;           ///< of a product with all lights at once
    double iteration_seconds = 0.0; ///< of the solution for all lights at once, to the tolerance of the bake
    std::size_t bytes = 0;          ///< of the operator
};

/// Of the lights of a solution, whose groups are kept apart if they are in the result; dark ones are left out. `tell`
/// is called with each trial. Phases: "iteration", "operator". Throws what the operators throw, and UsageError if
/// nothing is lit.
std::vector<OperatorTrial> try_operators(const BakeResult& result, std::span<const OperatorChoice> choices,
                                         const Execution& execution,
                                         const std::function<void(const OperatorTrial&)>& tell);

/// Comma-separated values with a header line: the fields of OperatorTrial.
std::string operator_csv(std::span<const OperatorTrial> trials);

} // namespace difusa
