// Whether light is as symmetric as the surface: only then half of it stands for the whole.
#pragma once

#include <difusa/scene/scene.h>

namespace difusa {

/// Throws InputError, with the remedy, unless the light is that of a symmetric scene about each symmetry plane of the
/// surface: each sun lies in the plane, or has its mirror image, of the same name, beside it; the sky is symmetric; no
/// point light is behind the plane, and one on it sends the same light to both sides. Periods ask nothing of light.
void check_light_symmetry(const Scene& scene);

} // namespace difusa
