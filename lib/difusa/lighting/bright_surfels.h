// The light of suns, point lights and area lights after one reflection, at a point. Where such light falls on a small
// part of the surface only, as that of the sun through a window does, few rays of a gather hit that part, and what it
// reflects comes out blotchy. There, points are drawn on the lit part itself as well.
#pragma once

#include <difusa/lighting/direct_light.h>
#include <difusa/lighting/surfel_light.h>

#include <cstdint>
#include <span>
#include <vector>

namespace difusa {

/// If most of the light of the first bounce comes from a small part of the surface, two kinds of samples are combined,
/// each weighted by the balance heuristic (Veach and Guibas 1995): the rays of a gather, which serve near and broad
/// surfaces best, and points drawn in proportion to the light of the surfels, which serve far and small ones best.
class BrightSurfels {
  public:
    /// `light`: that of all sets, on these surfels. Keeps references to scene, surfels and sources.
    BrightSurfels(const Scene& scene, const Tracer& tracer, const Surfels& surfels, const DirectLight& sources,
                  const SurfelLight& light);

    /// The part of the surface that would reflect as much as all of it does if all of that part were as bright as the
    /// mean by light: (sum q)² / (sum q²/A) over the area, for surfels of area A that reflect q. 0 if nothing is lit.
    double bright_share() const { return bright_share_; }

    /// Points drawn on bright surfels for a point that has so many rays: half as many, or none if more than `broad` of
    /// the surface is bright.
    std::size_t places(std::size_t rays) const { return below_.empty() ? 0 : (rays + 1) / 2; }
    static constexpr double broad = 0.25;

    struct Worker {
        DirectLight::Worker light; ///< its `cast` counts all segments
        std::vector<SurfacePoint> places;
        std::vector<Index> surfel; ///< #places
        std::vector<Segment> segments;
        std::vector<std::uint8_t> blocked;
        std::vector<Surfels::Piece> pieces;
        std::vector<Rgb> H;
    };

    /// D (rho ∘ H) at x: #sets #channels, W/m². The row of D has the bins `hit` with these weights (those that are no
    /// surfels are passed over) and comes from `rays` rays. `first_bounce`: rho ∘ H of the surfels. Near surfels are
    /// served by rays alone.
    Eigen::RowVectorXd gather(const SurfacePoint& x, std::span<const Index> hit, std::span<const double> weight,
                              std::size_t rays, const Values& first_bounce, RandomStream& stream, Worker& worker) const;

    /// The same by fresh shadow rays, at the points that the rays from x hit and at those that are drawn: H[set], in
    /// W/m². `met`: the points on front faces that rays hit; `weight`: these rays' weights, parallel to it; `rays`: how
    /// many there were, those included that hit no front.
    void gather_exactly(const SurfacePoint& x, std::span<const SurfacePoint> met, std::span<const double> weight,
                        std::size_t rays, RandomStream& stream, Worker& worker, std::span<Rgb> H) const;

  private:
    void draw(const SurfacePoint& x, std::size_t count, RandomStream& stream, Worker& worker) const;
    double density(Index s) const;
    double ray_density(const SurfacePoint& x, const Vec3& y, const Vec3& n_y) const;

    const Scene& scene_;
    Tracer tracer_;
    const Surfels& surfels_;
    const DirectLight& sources_;
    std::vector<double> below_; ///< for each surfel, the light of all before it; one more, the light of all
    std::vector<Index> centre_; ///< #surfels: place in `centres_`, none where a surfel is dark
    std::vector<std::pair<Vec3, Vec3>> centres_; ///< of bright surfels: position and normal
    double bright_share_ = 0.0;
};

} // namespace difusa
