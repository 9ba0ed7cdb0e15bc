// AreaLights: small emitting faces. A few hundred rays in all directions hit a small area light so rarely that its
// light comes out blotchy; its form factor is known exactly, and shadow rays estimate how much of it is visible.
// Surfaces that emit over a large part of the scene are left to the gather rays, which are then unbiased and, in a
// closed scene of constant emission, exact.
#pragma once

#include <difusa/core/random.h>
#include <difusa/lighting/lamp_images.h>
#include <difusa/lighting/light_shares.h>
#include <difusa/lighting/light_tree.h>
#include <difusa/lighting/shadow_batches.h>
#include <difusa/rays/lambert_batch.h>
#include <difusa/rays/polygon_in_sight.h>
#include <difusa/rays/tracer.h>
#include <difusa/scene/scene.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace difusa {

/// 1 for each material whose faces are area lights: among those that emit evenly, the ones of smallest area, as long as
/// together they cover at most a tenth of the surface; but no material less than four times as bright as the mean of
/// the remaining surface, which then lights the scene so evenly that rays serve both. In a thermal scene the magnitude
/// of the emission counts; there are none besides mirrors, nor materials whose temperature is to be found.
std::vector<char> area_light_materials(const Scene& scene);

/// The faces that may come between a place and a light. Keeps a reference.
class LightBlockers {
  public:
    explicit LightBlockers(const Mesh& mesh);

    /// Shafts::may_be_blocked.
    bool may_hide(Index light, const SurfacePoint& x, Index& last) const;

    /// What x sees of a light (rays/polygon_in_sight.h).
    PolygonInSight::Extent look(Index light, const SurfacePoint& x, PolygonInSight& sight) const;

  private:
    /// For views from x.
    const Shafts& shafts(const SurfacePoint& x) const { return between_ && x.face != none ? *between_ : all_; }

    Shafts all_;
    std::optional<Shafts> between_; ///< two points of the surface; none for large meshes, where all may
};

/// The area lights of a scene, and the light they send to a point: also from images beyond symmetry planes and periods,
/// which are area lights of their own here. Keeps references to scene and mesh.
class AreaLights {
  public:
    AreaLights(const Scene& scene, std::vector<Index> triangles, const Tracer& tracer);

    std::size_t count() const { return count_; } ///< without images

    /// Periods, or reflections in a row, over which images are found (LampImages::depth).
    std::size_t depth() const { return depth_; }

    /// Per-thread scratch and statistics.
    struct Worker {
        struct Part {
            Index triangle;
            double form_factor, weight; ///< weight: number of lights it represents, 1 / its probability
            double light;               ///< strength of the unblocked irradiance from them
            std::size_t share;          ///< in `shares`
            double below = 0.0;         ///< running sum of the chances of being chosen, or of `light`
            double factor = 1.0;        ///< on the light of each shadow ray to it
        };
        std::vector<double> factors; ///< #lights: form factors
        std::vector<Part> parts;     ///< lights; after `look`, those that shadow rays are cast to
        LightShares shares;
        std::vector<Index> nodes;
        std::vector<LightTree::Part> node_parts;
        std::vector<LightTree::Representative> chosen;
        std::vector<Segment> segments;
        std::vector<Rgb> light;
        std::vector<std::size_t> owner; ///< #segments: in `shares`
        std::vector<std::uint8_t> blocked;
        PolygonInSight sight;
        Index last_blocker = none;       ///< Shafts::may_be_blocked
        Rgb variance = Rgb::Zero();      ///< of the last `irradiance`, W²/m⁴
        std::size_t cast = 0;            ///< segments
        std::size_t blocked_samples = 0; ///< of `cast`, by `sample`
        std::size_t clear = 0;           ///< points that needed no shadow rays: nothing is in the way, or little
    };

    /// Adds the irradiance in W/m² that x receives to H[set_of[m]], for the lights of each material m: closed-form form
    /// factors (rays/lambert.h) times the visible share. The contribution of a material does not depend on how
    /// materials are assigned to sets.
    ///
    /// Up to 4096 lights are all evaluated. Of more, those of a group that x sees under a small angle are represented
    /// by some of them, about eight for each sample, chosen at random (LightTree::represent): unbiased.
    ///
    /// Visible share: exact where few faces reach between x and not too many lights (rays/polygon_in_sight.h), and no
    /// ray is cast. Otherwise by shadow rays, `samples` as pilots and as many or more that count
    /// (lighting/shadow_batches.h), stratified over the lights and weighted by the integrand: half of them by their
    /// contribution, and half evenly, so that no light is hidden by brighter ones. Unbiased but for the ratio of the
    /// sums of all rays.
    void irradiance(const SurfacePoint& x, std::size_t samples, RandomStream& stream, Worker& worker,
                    std::span<const Index> set_of, std::span<Rgb> H) const;

    /// The contribution of one light at x.
    struct Sample {
        Index material = none; ///< none: nothing
        Rgb H = Rgb::Zero();
        Vec3 towards = Vec3::Zero(); ///< unit, if it was asked for
    };

    /// True if `sample` chooses among the lights by their form factors, which adds no noise; else there are so many
    /// that the choice is rough.
    bool chooses_by_form_factors() const { return triangles_.size() <= few_chosen; }

    /// An unbiased estimate of all light with at most one shadow ray, from five random numbers in [0, 1): the light of
    /// one area light divided by the probability of choosing it, if the ray gets through. Where the lights are chosen
    /// by their form factors and no face reaches between x and the chosen one (Shafts), it is the irradiance itself,
    /// and no ray is cast; where all is occluded, 0.
    Sample sample(const SurfacePoint& x, const std::array<double, 5>& u, Worker& worker) const;

    /// The same for light whose direction matters: always of one point on the light, which is drawn in proportion to
    /// what it sends to x.
    Sample sample_direction(const SurfacePoint& x, const std::array<double, 5>& u, Worker& worker) const;

    static ShadowBatches shadow_batches(std::size_t samples) { return {samples, 1, 15}; }

    static constexpr std::size_t few_chosen = 24; ///< lights among which `sample` chooses by their form factors
    static constexpr std::size_t proposals = 8;   ///< of more, so many are looked at for a sample

    /// Shadow rays of `sample`, or as many as take its time.
    std::size_t rays_per_sample() const {
        return triangles_.empty() ? 0 : chooses_by_form_factors() ? 1 : 2 * proposals;
    }

  private:
    struct Choice {
        Index triangle = none;
        double weight = 0.0, form_factor = 0.0; ///< weight: 1 / probability
    };
    Choice choose(const SurfacePoint& x, double u, double along, Worker& worker) const;
    struct Target {
        Vec3 position;
        double form_factor = 0.0; ///< an unbiased estimate
    };
    bool is_blocked(const SurfacePoint& from, const Target& target, Index light, Worker& worker) const;
    Target target_on(const SurfacePoint& x, Index triangle, const std::array<double, 3>& u) const;
    bool lights(const SurfacePoint& x, Index triangle, double F) const;
    template <class Add> void for_each_facing(const SurfacePoint& x, Worker& worker, const Add& add) const;
    double form_factor(const SurfacePoint& x, Index triangle) const;
    /// The mesh of the lights, which has their images, too.
    const Mesh& lamps() const { return images_ ? *images_ : scene_.mesh; }
    /// The scene's triangle that a light is, or is an image of.
    Index original(Index light) const { return images_ ? originals_[light % count_] : light; }
    bool is_image(Index light) const { return images_ && light >= count_; }
    /// Whether the way to the light may lead through images, as it does from other parts of the unfolded surface.
    bool is_elsewhere(const SurfacePoint& x, Index light) const {
        return images_ && (light >= count_ || x.face == none);
    }
    bool may_be_blocked(const SurfacePoint& x, Index light, Index& last_blocker) const;
    const Rgb& emission(Index triangle) const { return scene_.materials[lamps().material[triangle]].emission; }
    /// By which lights are chosen: in thermal scenes they may emit less than nothing.
    double strength(Index triangle) const { return std::abs(emission(triangle).mean()); }
    void collect(const SurfacePoint& x, std::size_t samples, RandomStream& stream, Worker& worker) const;
    std::optional<double> visible_part(const SurfacePoint& from, Index light, Worker& worker) const;
    bool may_be_looked_at(const SurfacePoint& from, Index light) const;
    void look(const SurfacePoint& from, Worker& worker) const;
    void cast_batch(const SurfacePoint& x, std::size_t samples, const std::array<double, 3>& start,
                    Worker& worker) const;
    void cast_rays(const SurfacePoint& from, std::size_t samples, RandomStream& stream, Worker& worker) const;

    const Scene& scene_;
    Tracer tracer_;
    std::size_t count_ = 0, depth_ = 0;
    double rounding_ = 0.0;        ///< heights above planes that count as 0
    std::vector<Index> triangles_; ///< of `lamps`
    std::shared_ptr<const Mesh> images_;
    std::vector<Index> originals_; ///< if there are images
    LambertBatch batch_;           ///< of `triangles_`, unless there are too many to evaluate them all
    std::optional<LightTree> tree_;
    std::optional<LightBlockers> blockers_; ///< unless no face can block (Mesh::convex)
};

} // namespace difusa
