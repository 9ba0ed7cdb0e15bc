// Light that comes straight from sources that cast shadows with edges: suns, and lamps. It is computed at the very
// point where it is wanted and is no part of the unknown, so that no basis smooths its shadows (T chapter 8).
#pragma once

#include <difusa/core/progress.h>
#include <difusa/lighting/lamps.h>

#include <span>
#include <string_view>
#include <vector>

namespace difusa {

class DirectLight {
  public:
    /// Keeps references.
    DirectLight(const Scene& scene, const Visibility& visibility);

    /// False: there is no such light, and nothing below casts a ray.
    bool any() const { return !suns_.empty() || !lamps_.groups().empty(); }

    /// True if the emission of faces is counted here, so that the rays of a gather must not count it again.
    bool has_lamps() const { return !lamps_.groups().empty(); }
    std::size_t lamp_count() const;

    /// Shadow rays that `irradiance` casts for a point.
    std::size_t rays_per_point(std::size_t samples) const { return suns_.size() + samples * lamps_.groups().size(); }

    struct Worker {
        Lamps::Worker lamps;
        std::vector<Segment> segments;
        std::vector<std::uint8_t> blocked;
        std::vector<Index> owner;
        std::size_t cast = 0; ///< segments
    };

    /// The part of `irradiance` that comes from suns.
    Rgb from_suns(const SurfacePoint& x, Worker& worker) const;

    /// Irradiance at x in W/m², per channel: one shadow ray for each sun, `samples` for the lamps of each material.
    Rgb irradiance(const SurfacePoint& x, std::size_t samples, RandomStream& stream, Worker& worker) const;

    /// The same at many points, #x by `channels`; point i draws from the stream (seed, purpose, i). Adds the segments
    /// cast to `cast`.
    Values irradiance(std::span<const SurfacePoint> x, int channels, std::size_t samples, std::uint64_t seed,
                      std::string_view purpose, const Execution& execution, std::size_t& cast) const;

    /// Estimates with one shadow ray for each sun and one for all lamps together: H[i] at x[i]. Exact for suns; in the
    /// mean for lamps (Lamps::sample).
    void sample(std::span<const SurfacePoint> x, RandomStream& stream, std::span<Rgb> H, Worker& worker) const;

  private:
    Segment towards(const SurfacePoint& x, const Sun& sun) const;
    const Visibility& visibility_;
    std::vector<Sun> suns_; ///< those that shine
    double reach_;          ///< a length that leads out of the scene from any point of it
    Lamps lamps_;
    const Scene& scene_;
};

} // namespace difusa
