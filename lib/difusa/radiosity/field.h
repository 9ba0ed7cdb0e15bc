// The solution of the radiosity equation as a function on the surface.
#pragma once

#include <difusa/core/types.h>
#include <difusa/discretisation/evaluate.h>
#include <difusa/lighting/bright_surfels.h>
#include <difusa/lighting/direct_light.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace difusa {

class ExactCorrection;
class RadiositySystem;

/// The components of a field. Everything is shared, so that a field may outlive the bake that made it. Values have the
/// channels of each set of lights in turn.
struct FieldParts {
    std::shared_ptr<const RadiositySystem> system;
    std::shared_ptr<const Scene> scene;          ///< the system's surface with this field's lights
    std::shared_ptr<const DirectLight> direct;   ///< sharp sources, whose light is not represented in the basis
    std::shared_ptr<const BrightSurfels> bright; ///< their light after one reflection, and bright parts of emitters;
                                                 ///< null if there is none, or if the coefficients represent it
    Values
        soft_direct; ///< #S: coefficients of the direct light from the sky and from emitters that are not area lights
    Values smooth;   ///< #S: coefficients of h: all light except that of sharp sources
    /// #surfels: what each sends, W/m², of direct and, after as many columns, of indirect light, for corrections of
    /// gathers (exact_correction.h); null if the system has no exact form factors, or gloss besides.
    std::shared_ptr<const Values> sent = nullptr;
    int channels = 3;
    std::size_t shadow_rays = 64; ///< AreaLights::irradiance
    bool direct_in_basis = false; ///< the coefficients represent the light of sharp sources too
};

/// Irradiance at points, in W/m²: #points by the channels of each set in turn.
struct Irradiance {
    Values direct, indirect;
    /// Of gathers, #points by 1: the expected variance of what the rays bring from the sky, from emitters and of smooth
    /// light, of all sets together and summed over the channels, W²/m⁴ (gathering_noise.h). Light that bright surfels
    /// are sampled for, and the first reflection of sharp sources, is not included.
    Values variance;
    Values variance_of_sharp;           ///< of Field::evaluate (DirectLight::irradiance); empty without penumbras
    std::size_t rays = 0, segments = 0; ///< cast
    std::size_t clear = 0;              ///< points that needed no shadow rays to area lights
};

/// The light of one set at points, W/m².
struct GroupValues {
    std::string name;
    Values B, H; ///< #points by 3
};

/// Everything about the light at points: #points by 3, W/m² except rho. A grey scene has three equal columns.
struct PointValues {
    Values B;          ///< radiosity, E + rho H
    Values H;          ///< irradiance, direct and indirect
    Values H_direct;   ///< directly from lights, the sky and emitting faces
    Values H_indirect; ///< after one reflection or more
    Values rho;        ///< reflectance at the exact point
    Values E;          ///< emitted radiosity at the exact point
    /// Points whose light is gathered, ascending: all with a final gather, else those that no element reaches.
    std::vector<std::size_t> gathered;
    // Estimated noise due to gathering, root mean squares over the channels: #gathered by 1.
    Values noise;                 ///< of B, in thermal scenes of H
    Values noise_of_irradiance;   ///< of H
    std::size_t rays_of_each = 0; ///< of the gathered points
    /// Of H, of the light of sharp sources, #points by #channels, W²/m⁴; 0 at gathered points, where `noise` includes
    /// it. Empty if no light casts penumbras.
    Values variance_of_sharp;
    std::vector<GroupValues> groups;    ///< empty if all light is one set; their B and H add up to B and H
    std::size_t rays = 0, segments = 0; ///< cast
    std::size_t clear = 0;              ///< points that needed no shadow rays to area lights
};

///     B(x) = E(x) + rho(x) H(x),   H(x) = H_sharp(x) + h(x),
/// where H_sharp, the light of suns, point lights and area lights, is evaluated at x, and h is either sum_i c_i
/// phi_i(x) (`evaluate`) or gathered with fresh rays from x (`gather`): the iterated projection (Sloan 1976), known in
/// graphics as "final gather", which uses the light at the exact hit points of the rays rather than that of their
/// surfels.
///
/// Points may lie on edges: basis functions are then looked up, and rays start, slightly inside their faces
/// (mesh/surface_sampling.h, inset), while directly evaluated light is that of the exact point. `evaluate`,
/// `evaluate_smooth` and `at` throw UsageError for points in mid-air.
class Field {
  public:
    explicit Field(FieldParts parts) : parts_(std::move(parts)) {}

    const FieldParts& parts() const { return parts_; }
    int channels() const { return parts_.channels; }
    const LightSets& sets() const { return parts_.direct->sets(); }

    /// `seed` and `purpose` select the random streams of shadow rays, one per point.
    Irradiance evaluate(std::span<const SurfacePoint> x, std::uint64_t seed, std::string_view purpose,
                        const Execution& execution, const RowVisitor& visit = {}) const;

    /// h from `rays` rays from each point:
    ///     h(x) = sky + mean over the rays of E(y) + rho(y) (H_sharp(y) + sum_i c_i phi_i(y)).
    /// The mean error over the points is the error of `evaluate` reduced by one reflection (at most by the factor of
    /// the reflectance), plus the noise of the rays. Hits that no element reaches receive as much as x, unless more
    /// than a tenth of the surface is without elements. `correction`: for these points, or null.
    Irradiance gather(std::span<const SurfacePoint> x, std::size_t rays, std::uint64_t seed, std::string_view purpose,
                      const Execution& execution, const ExactCorrection* correction = nullptr) const;

    /// Two independent halves of what `at` gathers: with half of the rays each, and exact form factors if the system
    /// has them.
    void gather_twice(std::span<const SurfacePoint> x, std::size_t rays, std::uint64_t seed, const std::string& purpose,
                      const Execution& execution, Irradiance& first, Irradiance& second) const;

    /// What `evaluate` and `gather` give without the light of sharp sources (except what the coefficients represent).
    Irradiance evaluate_smooth(std::span<const SurfacePoint> x, const Execution& execution, bool displayed = false,
                               const RowVisitor& visit = {}) const;
    Irradiance gather_smooth(std::span<const SurfacePoint> x, std::size_t rays, std::uint64_t seed,
                             std::string_view purpose, const Execution& execution) const;

    /// Light of the surfels: #surfels by the channels of each set in turn, W/m².
    struct SurfelMeans {
        Values smooth;                  ///< P c
        Values first_bounce;            ///< SurfelLight::first_bounce
        std::vector<std::uint8_t> even; ///< SurfelLight::even
    };

    /// What `gather_smooth` gives where elements reach all hits, with the same rays and no bias, in less time: as if
    /// sum_i c_i phi_i, and direct light where it is even, were at each hit their means over the surfel, plus 16 times
    /// the difference at the hits of one ray of 16: that varies little, and adds little to the noise. With
    /// `correction`, which leaves no other noise than that within surfels, it is one of 8.
    Irradiance gather_by_surfels(std::span<const SurfacePoint> x, const SurfelMeans& means,
                                 const ExactCorrection* correction, std::size_t rays, std::uint64_t seed,
                                 std::string_view purpose, const Execution& execution) const;

    /// H_sharp: #x by the channels of each set in turn. Adds the rays cast to `effort`. `variance`:
    /// DirectLight::irradiance.
    Values sharp(std::span<const SurfacePoint> x, std::uint64_t seed, std::string_view purpose,
                 const Execution& execution, DirectLight::Effort& effort, Values* variance = nullptr) const;

    /// E + rho H for the irradiance H of each set, summed over the sets: #x by #channels.
    Values radiosity(std::span<const SurfacePoint> x, const Values& H) const;

    /// Everything at points, with no sum of irradiances below 0, except of thermal scenes. `final_gather` rays from
    /// each (an even number), in two independent halves whose difference gives the noise; 0: the basis is evaluated,
    /// and shown to `visit`. At points that no element reaches, such as the tip of a pit that no site sees into, all
    /// light is gathered, with 256 rays, unless more than a tenth of the surface is without elements. Gathers use exact
    /// form factors where FieldParts::sent is known. Throws UsageError for points without a face of the mesh.
    PointValues at(std::span<const SurfacePoint> x, std::size_t final_gather, std::uint64_t seed,
                   const std::string& purpose, const Execution& execution, const RowVisitor& visit = {}) const;

  private:
    void require_on_surface(std::span<const SurfacePoint> x) const;
    Irradiance gather_smooth(std::span<const SurfacePoint> x, const SurfelMeans* means,
                             const ExactCorrection* correction, std::size_t rays, std::uint64_t seed,
                             std::string_view purpose, const Execution& execution) const;
    Irradiance gather_with_noise(std::span<const SurfacePoint> x, std::size_t rays, std::uint64_t seed,
                                 const std::string& purpose, const Execution& execution, PointValues& values) const;
    std::vector<std::size_t> out_of_reach(std::span<const SurfacePoint> x, const Irradiance& H, std::uint64_t seed,
                                          const std::string& purpose, const Execution& execution) const;
    Irradiance irradiance(std::span<const SurfacePoint> x, std::size_t final_gather, std::uint64_t seed,
                          const std::string& purpose, const Execution& execution, const RowVisitor& visit,
                          PointValues& values) const;

    FieldParts parts_;
};

/// Light is not negative, but a basis with negative weights may undershoot at edges: where the sum of all sets does,
/// all of them become 0, so that they still add up to the total. `H`: #points by #sets #channels.
void raise_to_zero(Values& H, int channels);

} // namespace difusa
