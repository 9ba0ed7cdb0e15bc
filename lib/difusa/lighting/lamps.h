// Lamps: emitting faces that are small. A few hundred rays in all directions meet a small lamp so seldom that its light
// comes out blotchy; its form factor is known exactly, and shadow rays tell which share of it is seen. Surfaces that
// emit over a large part of the scene are left to the rays of the gather, which then are exact in the mean and, in a
// closed scene of constant emission, exact.
#pragma once

#include <difusa/core/random.h>
#include <difusa/scene/scene.h>
#include <difusa/visibility/visibility.h>

#include <cstdint>
#include <span>
#include <vector>

namespace difusa {

/// The emitting triangles that are lamps: all of them, if they make at most a tenth of the surface, number at most
/// 4096, have at most 32 materials and no pattern on them; else none.
std::vector<Index> lamp_triangles(const Scene& scene);

/// The lamps of a scene, by material, and the light they send to a point. Keeps references to scene and visibility.
class Lamps {
  public:
    Lamps(const Scene& scene, const std::vector<Index>& triangles, const Visibility& visibility);

    /// The lamps of one material.
    struct Group {
        Index material = none;
        std::vector<Index> triangles;
    };
    const std::vector<Group>& groups() const { return groups_; } ///< by material, ascending

    /// Scratch of one thread, and how many segments it cast.
    struct Worker {
        std::vector<double> form_factor, weight;
        std::vector<Segment> segments;
        std::vector<std::uint8_t> blocked;
        std::size_t cast = 0;
    };

    /// The form factor from x to the lamps of the group times the share of them that x sees: what x receives from them
    /// at unit radiosity. The form factor is exact (lighting/lambert.h); the share comes from `samples` shadow rays,
    /// stratified over the lamps by their form factors and weighted by the integrand: exact where nothing blocks.
    double visible_form_factor(const SurfacePoint& x, const Group& group, std::size_t samples, RandomStream& stream,
                               Worker& worker) const;

    /// Writes an estimate of the irradiance in W/m² that all lamps send to x, made with one shadow ray. Its mean is the
    /// irradiance, but for a lamp nearer than three times its size that is partly hidden.
    Rgb sample(const SurfacePoint& x, RandomStream& stream, Worker& worker) const;

  private:
    struct Choice {
        Index triangle = none;
        double probability = 0.0, form_factor = -1.0; ///< form factor: below 0 if it was not needed
    };
    Choice choose(const SurfacePoint& x, RandomStream& stream, Worker& worker) const;
    void place_samples(const SurfacePoint& x, const Group& group, double F, std::size_t samples, RandomStream& stream,
                       Worker& worker) const;

    const Scene& scene_;
    const Visibility& visibility_;
    std::vector<Group> groups_;
    std::vector<Index> triangles_;
    std::vector<double> power_; ///< running sum over `triangles_` of area times mean emission
};

} // namespace difusa
