// The attempts towards an accuracy as a chart.
#pragma once

#include <difusa/bake/result.h>

#include <string>

namespace difusa {

/// Error against the time since the first attempt began, both on log axes, as an SVG document: the estimate of each
/// attempt, the end of its interval that has to be below the target, and the target. With goals: the half width of the
/// widest of their intervals. `result` has attempts.
std::string error_chart_of(const BakeResult& result);

} // namespace difusa
