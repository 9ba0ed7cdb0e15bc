// Direct light of sources that cast sharp shadows: suns, point lights and area lights. It is evaluated exactly at the
// point of interest, outside the linear system, so that no basis smooths its shadows (T chapter 8). Direct is also what
// mirrors show of such sources.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/lighting/area_lights.h>
#include <difusa/lighting/mirror_images.h>
#include <difusa/lighting/narrow_beams.h>
#include <difusa/lighting/shadow_batches.h>
#include <difusa/scene/light_groups.h>

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace difusa {

/// The sharp sources of a scene. Their light is returned by set (scene/light_groups.h): one Rgb, or one column per
/// channel, for each set. Assigning lights to other sets changes sums over the sets by rounding only.
class DirectLight {
  public:
    static constexpr std::size_t most_sampled = 256; ///< suns, and point lights, that `sample` looks at

    /// Keeps references to the scene and what the tracer refers to. Throws InputError if the light is not as symmetric
    /// as the surface (scene/light_symmetry.h).
    DirectLight(const Scene& scene, const Tracer& tracer, LightSets sets);

    /// All lights in one set.
    DirectLight(const Scene& scene, const Tracer& tracer) : DirectLight(scene, tracer, all_lights(scene)) {}

    /// False: there are no such lights, and nothing below casts a ray.
    bool any() const { return !suns_.empty() || !points_.empty() || area_lights_.count() > 0; }

    const LightSets& sets() const { return sets_; }

    /// For each material, 1 if the emission of its faces is included here and must not be counted again where rays hit
    /// them (lighting/area_lights.h).
    const std::vector<char>& area_light_materials() const { return area_light_materials_; }
    std::size_t area_light_count() const { return area_lights_.count(); }

    /// Whether there are lights with an extent, whose shadows have penumbras.
    bool casts_penumbras() const { return extended_ > 0 || area_lights_.count() > 0; }

    /// Shadow rays that `irradiance` casts for a point if all area lights need some: outside of penumbras, and in all
    /// of them.
    std::size_t rays_per_point(std::size_t samples) const { return rays_of_batches(samples, false); }
    std::size_t most_rays_per_point(std::size_t samples) const { return rays_of_batches(samples, true); }

    /// Those that `sample` casts for a point, or could in the time that it takes to choose among many area lights.
    std::size_t rays_per_sample() const {
        return std::min(suns_.size(), most_sampled) + std::min(points_.size(), most_sampled) +
               area_lights_.rays_per_sample() + (images_ ? images_->rays_per_sample() : 0);
    }

    /// Of an infinite series of images beyond symmetry planes and periods: how many periods, or reflections in a row,
    /// away light of lamps is looked for; 0: there are none, or no such lamps.
    std::size_t depth_of_images() const;

    /// What mirrors show of the sources; null if they show none.
    const MirrorImages* images() const { return images_ ? &*images_ : nullptr; }

    const NarrowBeams& narrow_beams() const { return narrow_beams_; } ///< of point lights

    struct Worker {
        AreaLights::Worker area_lights;
        MirrorImages::Worker images;
        std::vector<Segment> segments;
        std::vector<std::uint8_t> blocked;
        std::vector<std::size_t> owner; ///< index into H
        std::vector<Rgb> light;
        std::vector<double> below;  ///< weights up to and including each point light
        Rgb variance = Rgb::Zero(); ///< of the last `irradiance`, all sets together, as its rays tell it, W²/m⁴
        std::size_t cast = 0;       ///< segments, excluding those of the area lights and images
        std::size_t total_cast() const { return cast + area_lights.cast + images.cast; }
    };

    /// Ray statistics, summed over threads.
    struct Effort {
        std::size_t segments = 0;
        std::size_t clear = 0; ///< points that needed no shadow rays to area lights (AreaLights::Worker::clear)
        void add(const Worker& worker) {
            segments += worker.total_cast();
            clear += worker.area_lights.clear;
        }
    };

    /// Irradiance at x in W/m², H[set], at exactly that point even if x is on an edge and shadow rays start next to it
    /// (mesh/surface_sampling.h, inset): one shadow ray for each sun and point light, `samples` or more for the area
    /// lights (AreaLights::irradiance). A sun with a disc and a luminaire with an opening: the exact light without
    /// obstacles times the visible share, by samples / 2 shadow rays or more (lighting/shadow_batches.h).
    void irradiance(const SurfacePoint& x, std::size_t samples, RandomStream& stream, Worker& worker,
                    std::span<Rgb> H) const;

    /// The same, for all sets together.
    Rgb irradiance(const SurfacePoint& x, std::size_t samples, RandomStream& stream, Worker& worker) const;

    /// The same at many points, #x by #sets times `channels`; point i draws from the stream (seed, purpose, i).
    /// `variance`, unless it is null: of the noise of shadow rays, all sets together, #x by `channels`, W²/m⁴.
    Values irradiance(std::span<const SurfacePoint> x, int channels, std::size_t samples, std::uint64_t seed,
                      std::string_view purpose, const Execution& execution, Effort& effort,
                      Values* variance = nullptr) const;

    /// Estimates with one shadow ray for each sun and point light and one for all area lights together: for x[i] from
    /// H[i #sets] on. Exact except for area lights (AreaLights::sample) and extended suns and luminaires, which are
    /// unbiased, and for more than
    /// `most_sampled` suns, or point lights with their images, of which that many are drawn, likewise unbiased: suns by
    /// their strength, point lights by their strength, direction and distance from x[i].
    /// `from_outside`, #x unless it is empty, is set to the part from suns and point lights.
    void sample(std::span<const SurfacePoint> x, RandomStream& stream, std::span<Rgb> H, Worker& worker,
                std::span<Rgb> from_outside = {}) const;

    /// True if area lights are so many that values of `sample` differ by chance (AreaLights::chooses_by_form_factors).
    bool chooses_roughly() const { return !area_lights_.chooses_by_form_factors(); }

    /// What arrives at a place from one direction.
    struct Arrival {
        std::size_t place = 0; ///< in x
        Index set = 0;
        Vec3 towards;              ///< unit, from the place
        Rgb H;                     ///< irradiance, W/m²
        bool from_outside = false; ///< from a sun or a point light
    };

    /// The same as a list of samples with their directions, whose sums have the same expectations, for surfaces that
    /// do not reflect all directions alike. What mirrors show is not included.
    void sample_directions(std::span<const SurfacePoint> x, RandomStream& stream, std::vector<Arrival>& arrivals,
                           Worker& worker) const;

  private:
    using Place = std::array<double, 2>; ///< on the disc or opening of a light
    // Collect the shadow rays of x towards all suns and point lights, at most `most_sampled` of each, or one, whose
    // light, times a factor, goes to H[first + set].
    void add_outside(const SurfacePoint& x, std::size_t first, Worker& worker) const;
    void add_drawn(const SurfacePoint& x, std::size_t first, const Place& place, RandomStream& stream,
                   Worker& worker) const;
    void add_sun(const SurfacePoint& x, const SurfacePoint& from, std::size_t sun, double factor, const Place& place,
                 std::size_t first, Worker& worker) const;
    void add_point(const SurfacePoint& x, const SurfacePoint& from, std::size_t point, double factor,
                   const Place& place, std::size_t first, Worker& worker) const;
    /// For an extended sun or luminaire.
    static ShadowBatches shadow_batches(std::size_t samples) { return {samples, 2, 8}; }
    std::size_t rays_of_batches(std::size_t samples, bool penumbra) const {
        return suns_.size() + points_.size() - extended_ + extended_ * shadow_batches(samples).all_rays(penumbra) +
               (area_lights_.count() > 0 ? AreaLights::shadow_batches(samples).all_rays(penumbra) : 0) +
               (images_ ? images_->rays_per_point(samples, penumbra) : 0);
    }
    void add_extended(const SurfacePoint& x, std::size_t samples, RandomStream& stream, Worker& worker,
                      std::span<Rgb> H) const;
    /// Of an extended source.
    struct Visible {
        double share = 0.0, variance = 0.0;          ///< of its light; of the share
        double light = 0.0, variance_of_light = 0.0; ///< mean over its places of what arrives, summed over the channels
    };
    template <class Add>
    Visible visible_share(std::size_t samples, RandomStream& stream, Worker& worker, const Add& add) const;
    void cast(Worker& worker) const;
    /// Casts one shadow ray from each x to each sun and point light, or to drawn ones; set 0 of x[i] is i #sets.
    void cast_drawn(std::span<const SurfacePoint> x, RandomStream& stream, Worker& worker) const;
    /// Calls `act(i, set, sample)` for each sample(i, u) of area lights, of `count`, that is one.
    template <class Sample, class Act>
    void for_each_lamp_sample(std::size_t count, RandomStream& stream, const Sample& sample, const Act& act) const;
    Segment shadow_ray(const SurfacePoint& from, const Vec3& direction, double length) const;

    const Scene& scene_;
    Tracer tracer_;
    LightSets sets_;
    std::vector<std::pair<Sun, Index>> suns_;          ///< those that shine, and their sets
    std::vector<std::pair<PointLight, Index>> points_; ///< likewise, with their images (lighting/lamp_images.h)
    std::vector<double> suns_below_;                   ///< strengths up to and including each one
    std::size_t extended_ = 0;                         ///< of both, with a disc or an opening
    std::size_t depth_ = 0;                            ///< of the images of point lights
    double reach_;                                     ///< a length that leads out of the scene from any of its points
    double rounding_;                                  ///< of a position computed from scene coordinates
    std::vector<char> area_light_materials_;
    AreaLights area_lights_;
    std::optional<MirrorImages> images_;
    NarrowBeams narrow_beams_;
};

} // namespace difusa
