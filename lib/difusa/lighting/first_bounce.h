// The light of suns, point lights and lamps after one reflection, at a point. Where such light falls on a small part of
// the surface only, as that of the sun through a window does, few rays of a gather meet that part, and what it reflects
// comes out blotchy. There, places are drawn on the lit part itself as well.
#pragma once

#include <difusa/lighting/direct_light.h>

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace difusa {

/// The surface is cut into cells small beside the elements of a basis, and the light that each reflects is measured
/// once, at a few places. If most of it comes from a small part of the surface, samples of two kinds are used from then
/// on, each weighted by the balance heuristic (Veach and Guibas 1995): the rays of a gather, which serve near and broad
/// surfaces best, and places drawn in proportion to the light of the cells, which serve far and small ones best. What
/// the cells miss the rays see, so that the mean is right whatever the cells are like.
class FirstBounce {
  public:
    /// Bytes that the cells take.
    static double memory(const Mesh& mesh, double spacing);

    /// `spacing`: site distance of the basis, a length. Keeps references to scene and visibility.
    FirstBounce(const Scene& scene, const Visibility& visibility, std::shared_ptr<const DirectLight> light,
                double spacing, std::uint64_t seed, const Execution& execution);

    /// The part of the surface that would reflect as much as all of it does if all of that part were as bright as the
    /// mean by light: (sum q)² / (sum q²/A) over the area, for cells of area A that reflect q. 0 if nothing is lit.
    double bright_share() const { return bright_share_; }

    /// Places drawn for a point that has so many rays: as many, or none if more than `broad` of the surface is bright.
    std::size_t places(std::size_t rays) const { return below_.empty() ? 0 : rays; }
    static constexpr double broad = 0.25;

    const DirectLight& light() const { return *light_; }

    /// Segments that measuring the cells took.
    std::size_t segments() const { return segments_; }

    struct Worker {
        DirectLight::Worker light; ///< its `cast` counts all segments
        std::vector<SurfacePoint> places;
        std::vector<Segment> segments;
        std::vector<std::uint8_t> blocked;
        std::vector<Rgb> H;
    };

    /// Irradiance at x in W/m², per channel. `met`: the front faces' places that the rays from x met; `weight`: these
    /// rays' weights, parallel to it (Surroundings); `rays`: how many there were, those included that met no front.
    Rgb irradiance(const SurfacePoint& x, std::span<const SurfacePoint> met, std::span<const double> weight,
                   std::size_t rays, RandomStream& stream, Worker& worker) const;

  private:
    void measure(std::size_t first, std::size_t last, RandomStream stream, Worker& worker);
    Index triangle_of(std::size_t cell) const;
    double chance(const SurfacePoint& y) const;
    double ray_density(const SurfacePoint& x, const SurfacePoint& y) const;
    SurfacePoint place(double light, double u, double v) const;

    const Scene& scene_;
    const Visibility& visibility_;
    std::shared_ptr<const DirectLight> light_;
    double cell_area_;               ///< largest
    std::vector<std::size_t> first_; ///< #T + 1: triangle t has the cells first_[t] to first_[t+1]
    std::vector<double> below_;      ///< for each cell, the light of all before it; one more, the light of all
    double bright_share_ = 0.0;
    std::size_t segments_ = 0;
};

} // namespace difusa
