// Light that comes straight from sources that cast shadows with edges: suns, point lights and lamps. It is computed at
// the very point where it is wanted and is no part of the unknown, so that no basis smooths its shadows (T chapter 8).
#pragma once

#include <difusa/core/progress.h>
#include <difusa/lighting/lamps.h>
#include <difusa/scene/light_groups.h>

#include <span>
#include <string_view>
#include <vector>

namespace difusa {

class DirectLight {
  public:
    /// All lights of the scene. Keeps references to scene and visibility.
    DirectLight(const Scene& scene, const Visibility& visibility);

    /// Those of `group` alone.
    DirectLight(const DirectLight& all, const LightGroup& group);

    /// False: there is no such light, and nothing below casts a ray.
    bool any() const { return !suns_.empty() || !points_.empty() || lamps_.count() > 0; }

    /// For each material 1 if what its faces emit, of whatever group, is counted by a DirectLight, so that the rays of
    /// a gather must not count it again (lighting/lamps.h).
    const std::vector<char>& lamp_materials() const { return lamp_materials_; }
    std::size_t lamp_count() const { return lamps_.count(); }

    /// Shadow rays that `irradiance` casts for a point where those of lamps settle at once.
    std::size_t rays_per_point(std::size_t samples) const {
        return suns_.size() + points_.size() + (lamps_.count() > 0 ? samples : 0);
    }

    /// And where they do not settle.
    std::size_t most_rays_per_point(std::size_t samples) const { return rays_per_point(samples * Lamps::most_rounds); }

    struct Worker {
        Lamps::Worker lamps;
        std::vector<Segment> segments;
        std::vector<std::uint8_t> blocked;
        std::vector<Index> owner;
        std::vector<Rgb> light;
        std::size_t cast = 0; ///< segments, without those of the lamps
    };

    /// What was cast, summed over threads.
    struct Effort {
        std::size_t segments = 0;
        std::size_t clear = 0; ///< points that needed no shadow rays to lamps (Lamps::Worker::clear)
        void add(const Worker& worker) {
            segments += worker.cast + worker.lamps.cast;
            clear += worker.lamps.clear;
        }
    };

    /// The part of `irradiance` that comes from suns and point lights.
    Rgb from_outside(const SurfacePoint& x, Worker& worker) const;

    /// Irradiance at x in W/m², per channel, of the very place even where, from an edge, shadow rays start beside it
    /// (mesh/surface_sampling.h, inset): one shadow ray for each sun and point light, `samples` and more for the
    /// lamps (Lamps::irradiance).
    Rgb irradiance(const SurfacePoint& x, std::size_t samples, RandomStream& stream, Worker& worker) const;

    /// The same at many points, #x by `channels`; point i draws from the stream (seed, purpose, i).
    Values irradiance(std::span<const SurfacePoint> x, int channels, std::size_t samples, std::uint64_t seed,
                      std::string_view purpose, const Execution& execution, Effort& effort) const;

    /// Estimates with one shadow ray for each sun and point light and one for all lamps together: H[i] at x[i]. Exact
    /// but for lamps; of these in the mean (Lamps::sample).
    void sample(std::span<const SurfacePoint> x, RandomStream& stream, std::span<Rgb> H, Worker& worker) const;

  private:
    void add_lights(const LightGroup& group);

    /// Collects the shadow rays of x; `owner` is its number.
    void add_outside(const SurfacePoint& x, Index owner, Worker& worker) const;
    Segment shadow_ray(const SurfacePoint& from, const Vec3& direction, double length) const;

    const Scene& scene_;
    const Visibility& visibility_;
    std::vector<Sun> suns_;            ///< those that shine
    std::vector<PointLight> points_;   ///< likewise
    double reach_;                     ///< a length that leads out of the scene from any point of it
    double rounding_;                  ///< of a place computed from coordinates of the scene
    std::vector<char> lamp_materials_; ///< of all groups
    std::shared_ptr<const Shafts> shafts_;
    Lamps lamps_;
};

} // namespace difusa
