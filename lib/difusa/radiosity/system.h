// Geometry once, lighting any number of times: everything independent of light, and the solution for one lighting.
#pragma once

#include <difusa/algebra/solver.h>
#include <difusa/core/error.h>
#include <difusa/discretisation/discretisation.h>
#include <difusa/lighting/bright_surfels.h>
#include <difusa/lighting/surfel_light.h>
#include <difusa/radiosity/contraction.h>
#include <difusa/radiosity/energy.h>
#include <difusa/radiosity/field.h>
#include <difusa/rays/directions.h>
#include <difusa/rays/tracer.h>
#include <difusa/transport/light_transport.h>

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace difusa {

/// The components of a system.
struct SystemParts {
    std::shared_ptr<const Scene> scene;           ///< whose surface this is
    std::shared_ptr<const Visibility> engine;     ///< built over it
    std::shared_ptr<const Directions> directions; ///< of the rays from the points
    std::shared_ptr<const Solver> solver;
    Discretisation discretisation;
    LightTransport transport;
    std::uint64_t seed = 1;
    std::shared_ptr<const Directions> fresh = nullptr; ///< of all other rays; null: the same. Not fixed
                                                       ///< (Directions::is_fixed), so that they tell errors
    std::optional<Contraction> contraction = {};       ///< known of a system with the same operator
};

/// The discretised equation has no solution that its bounces add up to: its spectral radius is not below 1.
struct BouncesDoNotDieOut : NotConverged {
    using NotConverged::NotConverged;
};

/// How the light of suns, point lights and area lights is carried over its first reflection.
enum class FirstBounce {
    live, ///< samples on bright surfels supplement the rays where such light falls on a small part of the surface; by
          ///< the operator where it does not
    operator_only ///< D (rho ∘ H), a product without a ray; blotchy where few rays meet the bright part
};

/// How to light a system.
struct LightingOptions {
    LightSets sets;               ///< of the scene that is solved for; none: all lights in one set
    bool direct_in_basis = false; ///< suns, point lights and area lights are represented in the basis, too
    SolveOptions solve = {};      ///< tolerance, iterations
    std::size_t shadow_rays = 64; ///< AreaLights::irradiance
    FirstBounce first_bounce = FirstBounce::live;
    bool may_be_dark = false;   ///< light that reaches no front is no mistake: the solution is 0
    bool keep_iterates = false; ///< Solution::iterates
    bool limit = true; ///< if the field is evaluated with corrected coefficients, `limited` to plausible values
};

/// An approximation that the solver went through.
struct KeptIterate {
    std::size_t relaxations = 0, entries = 0; ///< Iterate::relaxations, Iterate::entries
    double residual = 0.0;                    ///< relative, as far as the solver knew it
    Values smooth;                            ///< FieldParts::smooth
};

/// The radiosity equation of one surface, solved for one lighting. Columns are the channels of each set in turn.
struct Solution {
    std::shared_ptr<const Field> field;
    SolveSummary solve; ///< h moved to `h`
    Values h;           ///< #points: irradiance, excluding sharp sources unless represented in the basis, W/m²
    Values direct;      ///< #S: irradiance directly from all lights, at the sites
    Values irradiance;  ///< #S: all irradiance
    SurfelLight light;  ///< on the surfels
    EnergyBalance energy;
    double spectral_radius = 0.0;            ///< of T
    bool spectral_radius_is_bound = false;   ///< Contraction::is_bound
    std::optional<FirstBounce> first_bounce; ///< the way it was computed; none if there is no such light, or if the
                                             ///< basis represents it
    std::size_t area_lights = 0;             ///< emitting triangles whose light was evaluated analytically
    std::vector<KeptIterate> iterates;       ///< those that the solver showed (SolveOptions::watch), if they were to be
                                             ///< kept; the last is the solution

    /// The field of one of `iterates`.
    std::shared_ptr<const Field> field_of(const KeptIterate& iterate) const;
};

/// Owned by a std::shared_ptr: the fields that it solves for keep it alive.
class RadiositySystem : public std::enable_shared_from_this<RadiositySystem> {
  public:
    explicit RadiositySystem(SystemParts parts) : parts_(std::move(parts)), contraction_(parts_.contraction) {}

    const SystemParts& parts() const { return parts_; }

    /// Of rays that are not those of the system's points.
    const Directions& fresh_directions() const { return parts_.fresh ? *parts_.fresh : *parts_.directions; }
    const Discretisation& discretisation() const { return parts_.discretisation; }
    const LightTransport& transport() const { return parts_.transport; }
    Tracer tracer() const { return {parts_.scene->mesh, *parts_.engine}; }

    /// The one that was used last; at first, that of the parts.
    std::optional<Contraction> contraction() const;

    /// Solves h = g + T h, where g is the light incident directly from emitters and the sky and, after one reflection,
    /// from suns, point lights and area lights. `scene`: this surface with any reflectances and lights. Phases: "light
    /// surfels", "direct light", "check convergence", "solve". No first-hit rays are cast.
    ///
    /// Throws UsageError if there is no scene or its surface differs, if the sets do not match its lights, or if light
    /// may reach surfaces without sites (SiteSet::dark); BouncesDoNotDieOut; NotConverged if the solver did not
    /// converge; InputError if no light reaches any front, or if check_materials_and_lights finds fault.
    Solution solve(const std::shared_ptr<const Scene>& scene, const LightingOptions& options,
                   const Execution& execution) const;

    /// The same for several scenes of this surface that differ in their lights alone: the linear systems of
    /// several are solved together, as columns of one matrix. With the solver krylov, each solution has the bits that
    /// it has alone, except for its number of iterations, which is that of all. Some of the scenes may be dark.
    /// `options.sets`: none, or those of every scene. Throws UsageError if reflectances differ, or if iterates of
    /// several are to be kept. All have three channels unless all are grey.
    std::vector<Solution> solve(std::span<const std::shared_ptr<const Scene>> scenes, const LightingOptions& options,
                                const Execution& execution) const;

    /// The irradiance at the points that a radiosity b of the surfels causes directly and by further reflections,
    /// h = D b + T h. `reflectance`: #surfels by #channels; `b`: #surfels by any number of columns, of which column c
    /// is reflected by channel c modulo #channels. The first bounce is computed, and the others are solved for, because
    /// b may be that of a few points: the tolerance is relative to D diag(rho) P Π D b, which is smooth. May be less
    /// accurate than asked for if the solver did not converge.
    Values respond(const Values& reflectance, const Values& b, const SolveOptions& options,
                   const Execution& execution) const;

  private:
    Contraction contraction_with(const Values& reflectance, const Execution& execution) const;
    void check_scene(const Scene& scene) const;
    SystemParts parts_;
    mutable std::mutex guard_;                       ///< of `contraction_`
    mutable std::optional<Contraction> contraction_; ///< the last one
};

} // namespace difusa
