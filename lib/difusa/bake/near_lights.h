// Point lights that make spots so small that what the surface reflects of them is not resolved.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/rays/tracer.h>
#include <difusa/scene/scene.h>

#include <cstddef>

namespace difusa {

/// Notes the point lights that shine on a surface from less than a quarter of the mean width of its surfels away, and
/// the spots and luminaires with a beam that is, where its axis meets the surface, narrower than a tenth of that width.
/// Their direct light is evaluated exactly, but reflected as the mean of some points of each surfel, which may all be
/// beside the bright spot; nor is the error estimate likely to find it.
void note_near_lights(const Scene& scene, const Tracer& tracer, std::size_t surfels, const Execution& execution);

} // namespace difusa
