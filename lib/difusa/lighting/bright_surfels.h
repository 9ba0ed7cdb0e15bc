// The light of suns, point lights and area lights after one reflection, and that of emitters with a texture or pattern,
// at a point. Where it comes only from a small part of the surface, as from a patch of sunlight or a display, few
// gather rays hit that part, and its light comes out blotchy. In that case the bright part itself is sampled as well.
#pragma once

#include <difusa/lighting/direct_light.h>
#include <difusa/lighting/surfel_light.h>

#include <cstdint>
#include <span>
#include <vector>

namespace difusa {

/// If most of this light comes from a small part of the surface, two kinds of samples are combined,
/// weighted by the balance heuristic (Veach and Guibas 1995): gather rays, which suit near and large surfaces, and
/// points sampled in proportion to the light of the surfels, which suit distant and small ones.
class BrightSurfels {
  public:
    /// `light`: of all sets, on these surfels. Keeps references to scene, surfels and sources.
    BrightSurfels(const Scene& scene, const Tracer& tracer, const Surfels& surfels, const DirectLight& sources,
                  const SurfelLight& light);

    /// The fraction of the surface that would reflect the same light of sharp sources if uniformly as bright as the
    /// light-weighted mean: (sum q)² / (sum q²/A) over the area, for surfels of area A that reflect q. 0 if nothing is
    /// lit. Bright surfels are those of such light and of emission, of each if its own fraction is at most `broad`.
    double bright_share() const { return bright_share_; }

    /// Samples on bright surfels for a point with this many rays: half as many, or none if there are none, or if the
    /// surface goes on beyond its mesh.
    std::size_t places(std::size_t rays) const { return below_.empty() ? 0 : (rays + 1) / 2; }
    static constexpr double broad = 0.25;

    /// Whether the light of emitters with a texture or pattern is that of `gather` and `gather_exactly`, because there
    /// are such and bright surfels are sampled.
    bool samples_emission() const { return emits_ && places(1) > 0; }

    struct Worker {
        DirectLight::Worker light; ///< its `cast` counts all segments
        std::vector<SurfacePoint> places;
        std::vector<Index> surfel; ///< #samples
        std::vector<Segment> segments;
        std::vector<std::uint8_t> blocked;
        std::vector<Surfels::Piece> pieces;
        std::vector<Rgb> H;
        std::vector<double> factor;           ///< #points, of their light
        std::vector<std::size_t> sampled;     ///< numbers of points with fresh shadow rays
        std::vector<SurfacePoint> sampled_at; ///< these points
    };

    /// The light of its surfel in place of that at each point, plus `stride` times the difference at one point of so
    /// many, which leaves no bias; not on surfels that are lit unevenly. `first_bounce`: rho ∘ H of the surfels.
    struct Shortcut {
        const Values& first_bounce;
        const std::vector<std::uint8_t>& even; ///< SurfelLight::even
        std::size_t stride = 1;
    };

    /// D b at x: as many columns as b, W/m². The row of D has the bins `hit` with these weights (bins that are not
    /// surfels are skipped) and was estimated with `rays` rays. `sent`: b, such as rho ∘ H of the surfels or their
    /// emission. Near surfels are served by rays alone.
    Eigen::RowVectorXd gather(const SurfacePoint& x, std::span<const Index> hit, std::span<const double> weight,
                              std::size_t rays, const Values& sent, RandomStream& stream, Worker& worker) const;

    /// D (rho ∘ H) at x with fresh shadow rays, at the hits of the rays and at the sampled points: H[set], in W/m²; and
    /// if emission is sampled, that of emitters with a texture or pattern: E[set].
    /// `met`: the hits on front faces; `weight`: the weights of these rays, parallel to it; `rays`: their total number,
    /// including those that hit no front. `shortcut`: or null.
    void gather_exactly(const SurfacePoint& x, std::span<const SurfacePoint> met, std::span<const double> weight,
                        std::size_t rays, RandomStream& stream, Worker& worker, std::span<Rgb> H, std::span<Rgb> E,
                        const Shortcut* shortcut = nullptr) const;

  private:
    void add_reflected(std::span<const SurfacePoint> y, RandomStream& stream, Worker& worker, std::span<Rgb> H,
                       const Shortcut* shortcut) const;
    void add_emitted(std::span<const SurfacePoint> y, const Worker& worker, std::span<Rgb> E) const;
    void draw(const SurfacePoint& x, std::size_t count, RandomStream& stream, Worker& worker) const;
    double density(Index s) const;
    double ray_density(const SurfacePoint& x, const Vec3& y, const Vec3& n_y) const;

    const Scene& scene_;
    Tracer tracer_;
    const Surfels& surfels_;
    const DirectLight& sources_;
    std::vector<double> below_; ///< running sum of the light of the surfels; the last entry is the total
    std::vector<Index> centre_; ///< #surfels: index into `centres_`, none for a dark surfel
    std::vector<std::pair<Vec3, Vec3>> centres_; ///< of bright surfels: position and normal
    double bright_share_ = 0.0;
    bool emits_ = false; ///< emitters with a texture or pattern are among the bright surfels
};

} // namespace difusa
