// A field: coefficients times basis functions, anywhere on the surface.
#pragma once

#include <difusa/core/types.h>
#include <difusa/discretisation/basis.h>

#include <cstddef>
#include <functional>
#include <span>

namespace difusa {

/// Is shown the elements at each point that a field is evaluated at, by Basis::evaluate, for finding them may take
/// longer than what is done with them. Called once for each point, by several threads.
using RowVisitor = std::function<void(std::size_t point, const BasisRow& row)>;

/// f(x) = sum_i b_i phi_i(x) for each point: #points by the columns of `coefficients` (#S by any number).
Values evaluate(const Basis& basis, const Values& coefficients, std::span<const SurfacePoint> points,
                const Execution& execution);

/// The same for the field that is displayed (Basis::display).
Values evaluate_display(const Basis& basis, const Values& coefficients, std::span<const SurfacePoint> points,
                        const Execution& execution, const RowVisitor& visit = {});

} // namespace difusa
