// Light by plain path tracing: slow, unbiased, and independent of everything but rays, so that a bake can be judged by
// it.
#pragma once

#include <difusa/core/random.h>
#include <difusa/rays/visibility.h>
#include <difusa/scene/scene.h>

namespace difusa {

/// Irradiance at x in W/m²: the mean of the paths, and the covariance of its channels, which have the same paths.
struct TracedLight {
    Rgb mean = Rgb::Zero();
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero(); ///< of the mean, W²/m⁴

    Rgb variance() const { return covariance.diagonal().array(); }
};

/// Every emitting face is sampled by area at each vertex of a path, so emission that a path runs into is not counted.
/// At a glossy surface a path goes on either as from a matt one or as from its lobe. No sky, no suns, no point lights,
/// no mirrors. Dark where nothing emits. `visibility`: built over the scene's mesh. `paths`: 2 or more.
TracedLight trace_paths(const Scene& scene, const Visibility& visibility, const SurfacePoint& x, std::size_t paths,
                        RandomStream stream);

} // namespace difusa
