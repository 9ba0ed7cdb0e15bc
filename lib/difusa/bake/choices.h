// The choices of a bake, as objects.
#pragma once

#include <difusa/bake/options.h>
#include <difusa/discretisation/basis.h>
#include <difusa/discretisation/projection.h>
#include <difusa/discretisation/sampler.h>
#include <difusa/plugin/registry.h>
#include <difusa/rays/directions.h>
#include <difusa/rays/visibility.h>
#include <difusa/transport/analytic_transport.h>
#include <difusa/transport/kernel.h>
#include <difusa/transport/mirror_patches.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace difusa {

/// A basis with its projection.
struct ElementChoice {
    std::shared_ptr<Basis> basis;
    ProjectionChoice projection;
    std::string basis_text, projection_text; ///< with all parameters

    std::string text() const { return basis_text + ", " + projection_text; }
};

/// Which faces are turned over (BakeOptions::flip).
enum class Flip { certain, all, nothing };

struct Choices {
    ElementChoice elements;
    std::optional<ElementChoice> fallback; ///< if bounces do not die out with these
    std::shared_ptr<Sampler> sampler;
    std::shared_ptr<Visibility> engine;
    std::shared_ptr<Directions> directions, fresh_directions; ///< SystemParts::directions, SystemParts::fresh
    std::shared_ptr<Kernel> kernel;                           ///< null unless pairwise
    std::shared_ptr<Solver> solver;
    bool pairwise = false;
    bool neighbour_areas = false;   ///< for pairwise transport
    MirrorPathOptions over_mirrors; ///< likewise
    bool direct_in_basis = false;   ///< BakeOptions::direct is "interpolated"
    AnalyticUse analytic = AnalyticUse::never;
    bool aims_at_openings = false; ///< rays to openings of the sky are possible (transport/skylight.h)
    bool operator_bounce = false;  ///< BakeOptions::first_bounce is "operator"
    bool stop_by_change = false;   ///< BakeOptions::stop is "change"
    bool may_be_dark = false;      ///< LightingOptions::may_be_dark
    Flip flip = Flip::certain;
    std::string sampler_name;                                 ///< BakeOptions::sampler, or the one it stands for
    std::string sensor;                                       ///< BakeOptions::sensor
    std::string visibility;                                   ///< the engine chosen by "auto"
    std::vector<std::string> notes;                           ///< about choices that were not available
    std::vector<std::pair<std::string, std::string>> plugins; ///< kind, and choice with all parameters, of the others
};

/// The sampler for a basis: `chosen`, or if that is empty the one it demands (Basis::sampler), or else poisson-disk.
/// Throws UsageError if the basis demands another than the chosen one. `basis_choice`: as typed.
std::string fitting_sampler(const std::string& chosen, const std::string& basis_choice, const Basis& basis);

/// Whether patches are divided into elements where it helps (bake/subdivided_patches.h).
bool is_subdivided(const Basis& basis, const BakeOptions& options);

/// True if sites can be added where they help to those that the options choose: gathered transport, a basis that any
/// sites will do for, and a sampler that covers all of the surface evenly. Throws UsageError for unknown names.
bool can_be_graded(const Registry& registry, const BakeOptions& options);

/// Throws UsageError for anything unknown, contradictory or without effect.
Choices make_choices(const Registry& registry, const BakeOptions& options);

} // namespace difusa
