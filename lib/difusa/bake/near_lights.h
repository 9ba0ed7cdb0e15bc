// Point lights so near a surface that what it reflects of them is not resolved.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/scene/scene.h>

#include <cstddef>

namespace difusa {

/// Notes the point lights that shine on a surface from less than a quarter of the mean width of its surfels away. Their
/// direct light is evaluated exactly, but reflected as the mean of a few points of each surfel, which may all be beside
/// the bright spot; nor is the error estimate likely to find it.
void note_near_lights(const Scene& scene, std::size_t surfels, const Execution& execution);

} // namespace difusa
