// What a surface point sees: the rays of one hemisphere, sorted by what they meet.
#pragma once

#include <difusa/rays/direction_pool.h>
#include <difusa/rays/visibility.h>
#include <difusa/scene/scene.h>

#include <span>
#include <vector>

namespace difusa {

/// Scratch of one thread; keeps references.
class Surroundings {
  public:
    Surroundings(const Mesh& mesh, const Visibility& visibility, const DirectionPool& pool)
        : mesh_(mesh), visibility_(visibility), pool_(pool), rays_(pool.count()), hits_(pool.count()) {}

    /// Casts the rays of point number `number` (DirectionPool::rays) from x, or from beside it if it is on an edge.
    /// Where the normal of x is a shading normal, directions below the plane of its face are mirrored to above it: the
    /// surface that the normal speaks of does not hide them.
    void look(const SurfacePoint& x, std::size_t number);

    std::span<const SurfacePoint> points() const { return points_; } ///< what the rays met on a front
    std::span<const double> weights() const { return weights_; }     ///< the rays' weights, parallel to `points`
    double sky() const { return sky_; }                              ///< weight of the rays that escape
    std::span<const Vec3> escaped() const { return escaped_; }       ///< their directions, unit
    std::span<const double> escaped_weights() const { return escaped_weights_; } ///< parallel to `escaped`
    double back() const { return back_; } ///< of those that meet the back of a face

  private:
    const Mesh& mesh_;
    const Visibility& visibility_;
    const DirectionPool& pool_;
    std::vector<Ray> rays_;
    std::vector<Hit> hits_;
    std::vector<SurfacePoint> points_;
    std::vector<double> weights_;
    std::vector<Vec3> escaped_;
    std::vector<double> escaped_weights_;
    double sky_ = 0.0, back_ = 0.0;
};

/// Irradiance from Scene::dome: pi times the mean of its radiance over the rays that escaped; 0 without one.
Rgb dome_irradiance(const Scene& scene, const Surroundings& around);

} // namespace difusa
