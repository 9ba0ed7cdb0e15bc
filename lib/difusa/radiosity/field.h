// The solution of the radiosity equation as a function on the surface.
#pragma once

#include <difusa/core/types.h>
#include <difusa/discretisation/basis.h>
#include <difusa/lighting/first_bounce.h>
#include <difusa/rays/directions.h>
#include <difusa/rays/visibility.h>

#include <cstdint>
#include <memory>
#include <span>

namespace difusa {

/// What a field is made of. Everything is shared, so that a field may outlive the bake that made it.
struct FieldParts {
    std::shared_ptr<const Scene> scene;
    std::shared_ptr<const SiteSet> sites;
    std::shared_ptr<const Basis> basis;           ///< bound to them
    std::shared_ptr<const Visibility> visibility; ///< built
    std::shared_ptr<const Directions> directions;
    std::shared_ptr<const DirectLight> direct; ///< sharp sources, whose light no basis carries
    std::shared_ptr<const FirstBounce> bounce; ///< their light after one reflection; null without any, or if
                                               ///< the coefficients hold it
    LightGroup group;                          ///< whose light this is; `direct` is of the same
    Values soft_direct; ///< #S by #channels: coefficients of the direct light of sky and of emitters that are no lamps
    Values smooth;      ///< likewise: coefficients of h, which is all light but that of sharp sources
    std::size_t lamp_samples = 64; ///< shadow rays of a round (Lamps::irradiance)
    bool direct_in_basis = false;  ///< the coefficients hold the light of sharp sources too
};

/// Irradiance at points, in W/m²: #points by #channels each.
struct Irradiance {
    Values direct, indirect;
    std::size_t rays = 0, segments = 0; ///< cast
    std::size_t clear = 0;              ///< points that needed no shadow rays to lamps (Lamps::Worker::clear)
};

///     B(x) = E(x) + rho(x) H(x),   H(x) = H_sharp(x) + h(x),
/// where H_sharp, the light of suns, point lights and lamps, is computed at x, and h is either sum_i c_i phi_i(x)
/// (`evaluate`) or
/// gathered anew from the surroundings of x (`gather`): the iterated projection (Sloan 1976), in graphics
/// "final gather".
///
/// Places may lie on edges: elements are then looked up, and rays start, a little inside of their faces
/// (mesh/surface_sampling.h, inset), and light that is computed is that of the very place.
class Field {
  public:
    explicit Field(FieldParts parts) : parts_(std::move(parts)) {}

    const FieldParts& parts() const { return parts_; }
    int channels() const { return static_cast<int>(parts_.smooth.cols()); }

    /// `seed` and `purpose` name the random streams of shadow rays, one for each point.
    Irradiance evaluate(std::span<const SurfacePoint> x, std::uint64_t seed, std::string_view purpose,
                        const Execution& execution) const;

    /// h by `rays` rays from each point:
    ///     h(x) = sky + mean over the rays of E(y) + rho(y) (H_sharp(y) + sum_i c_i phi_i(y)).
    /// The mean error over the points falls as the error of `evaluate` times what one reflection leaves of it (at most
    /// the reflectance), plus the noise of the rays.
    Irradiance gather(std::span<const SurfacePoint> x, std::size_t rays, std::uint64_t seed, std::string_view purpose,
                      const Execution& execution) const;

    /// E + rho H, #x by #channels.
    Values radiosity(std::span<const SurfacePoint> x, const Values& H) const;

  private:
    FieldParts parts_;
};

} // namespace difusa
