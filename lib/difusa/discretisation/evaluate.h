// A field: coefficients times basis functions, anywhere on the surface.
#pragma once

#include <difusa/core/types.h>
#include <difusa/discretisation/basis.h>

#include <span>

namespace difusa {

/// f(x) = sum_i b_i phi_i(x) for each point: #points by the columns of `coefficients` (#S by any number).
Values evaluate(const Basis& basis, const Values& coefficients, std::span<const SurfacePoint> points,
                const Execution& execution);

/// The same for the field that is displayed (Basis::display).
Values evaluate_display(const Basis& basis, const Values& coefficients, std::span<const SurfacePoint> points,
                        const Execution& execution);

} // namespace difusa
