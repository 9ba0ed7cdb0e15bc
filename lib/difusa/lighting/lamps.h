// Lamps: emitting faces that are small. A few hundred rays in all directions meet a small lamp so seldom that its light
// comes out blotchy; its form factor is known exactly, and shadow rays tell which share of it is seen. Surfaces that
// emit over a large part of the scene are left to the rays of the gather, which then are exact in the mean and, in a
// closed scene of constant emission, exact.
#pragma once

#include <difusa/core/random.h>
#include <difusa/lighting/light_tree.h>
#include <difusa/lighting/shaft.h>
#include <difusa/rays/visibility.h>
#include <difusa/scene/scene.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace difusa {

/// Which materials' faces are lamps, 1 for each that is: of those that emit evenly the ones of least area, as long as
/// together they make at most a tenth of the surface; but no material that is not four times as bright as the mean of
/// the surface that is left, which then lights the scene so evenly that rays serve both.
std::vector<char> lamp_materials(const Scene& scene);

/// Some lamps of a scene, and the light they send to a point. Keeps references to scene and visibility.
class Lamps {
  public:
    /// `shafts`: of the scene's mesh; null where no face can block (Mesh::convex).
    Lamps(const Scene& scene, std::vector<Index> triangles, const Visibility& visibility,
          std::shared_ptr<const Shafts> shafts);

    std::size_t count() const { return triangles_.size(); }

    /// Scratch of one thread, and what it did.
    struct Worker {
        struct Part {
            Index triangle;
            double form_factor, weight; ///< weight: what this lamp stands for, 1 / its probability
            double mean_below;          ///< running sum of the mean irradiance, as if nothing blocked
        };
        std::vector<Part> parts;
        std::vector<Index> nodes;
        std::vector<Segment> segments;
        std::vector<Rgb> light;
        std::vector<std::uint8_t> blocked;
        std::size_t cast = 0;  ///< segments
        std::size_t clear = 0; ///< points whose lamps nothing could hide, so that no shadow ray was needed
    };

    /// Irradiance in W/m² that x receives from all lamps: form factors in closed form (lighting/lambert.h) times the
    /// share that x sees.
    ///
    /// Many lamps: those of a group that x sees under a small angle are stood for by one of them, chosen at random
    /// (LightTree::cut): right in the mean, and exact where each lamp is alone in its group.
    ///
    /// Share: none is hidden where no face reaches between x and them (Shafts). Else `samples` shadow rays are cast,
    /// stratified over the lamps by what they send and weighted by the integrand, twice and again up to sixteen times
    /// until the rounds agree on the share to `settled`. Exact where nothing blocks.
    Rgb irradiance(const SurfacePoint& x, std::size_t samples, RandomStream& stream, Worker& worker) const;

    /// An estimate of the same with one shadow ray, from four random numbers in [0, 1): the light of one lamp if the
    /// ray gets through, else 0. Where the lamps are few and nothing blocks, it is the irradiance itself; where all is
    /// hidden, 0. In a penumbra its mean is right as far as the place the ray goes to, chosen among four by what they
    /// send, stands for the lamp.
    Rgb sample(const SurfacePoint& x, const std::array<double, 4>& u, Worker& worker) const;

    /// How far the shares of two rounds of shadow rays may be apart, in standard errors of their mean.
    static constexpr double settled = 0.002;
    static constexpr std::size_t most_rounds = 16;

  private:
    struct Choice {
        Index triangle = none;
        double weight = 0.0, form_factor = 0.0; ///< weight: 1 / probability
    };
    Choice choose(const SurfacePoint& x, double u, Worker& worker) const;
    Vec3 place_on(const SurfacePoint& x, Index triangle, const std::array<double, 3>& u) const;
    double form_factor(const SurfacePoint& x, Index triangle) const;
    const Rgb& emission(Index triangle) const { return scene_.materials[scene_.mesh.material[triangle]].emission; }
    void collect(const SurfacePoint& x, RandomStream& stream, Worker& worker) const;
    bool may_be_hidden(const SurfacePoint& x, const Worker& worker) const;
    void cast_round(const SurfacePoint& x, std::size_t samples, RandomStream& stream, Worker& worker, Rgb& seen,
                    Rgb& all) const;

    const Scene& scene_;
    const Visibility& visibility_;
    std::vector<Index> triangles_;
    std::optional<LightTree> tree_;
    std::shared_ptr<const Shafts> shafts_;
};

} // namespace difusa
