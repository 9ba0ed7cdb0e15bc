// Light by plain path tracing: slow, unbiased, and independent of everything but rays, so that a bake can be judged by
// it.
#pragma once

#include <difusa/core/random.h>
#include <difusa/rays/visibility.h>
#include <difusa/scene/scene.h>

namespace difusa {

/// Irradiance at x in W/m², the mean of `paths` paths, and its variance (of the mean).
struct TracedLight {
    Rgb mean = Rgb::Zero(), variance = Rgb::Zero();
};

/// Every emitting face is sampled by area at each vertex of a path, so emission that a path runs into is not counted.
/// At a glossy surface a path goes on either as from a matt one or as from its lobe. No sky, no suns, no point lights,
/// no mirrors. `visibility`: built over the scene's mesh.
TracedLight trace_paths(const Scene& scene, const Visibility& visibility, const SurfacePoint& x, std::size_t paths,
                        RandomStream stream);

} // namespace difusa
