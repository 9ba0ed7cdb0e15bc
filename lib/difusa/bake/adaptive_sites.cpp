#include <difusa/bake/adaptive_sites.h>

#include <difusa/bake/pilot.h>
#include <difusa/bake/sites_in_sight.h>
#include <difusa/discretisation/grading.h>
#include <difusa/discretisation/poisson_disk.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace difusa {

namespace {

/// The sites of the pilots one by one, of those wanted. The first are evenly spaced, and stay.
constexpr std::array<double, 2> pilot_shares{0.25, 0.5};
static_assert(pilot_shares[0] + pilot_shares[1] == pilot_sites);

/// Of the wanted sites: how many those of an earlier bake have to be to stand in for each of the pilots.
constexpr std::array<double, 2> known_shares{0.125, 1.0 / 3.0};

constexpr double least_gain = 2.0;           ///< in the squared error at best, for which sites are graded
constexpr double negligible_error = 0x1p-12; ///< of a pilot's light, for which sites are graded
constexpr double most_even = 0.75;           ///< of the wanted sites may be needed for one on each part of the surface
constexpr double close_enough = 0.05;        ///< to the wanted number of sites
constexpr int most_attempts = 3;             ///< at it

/// The error of evenly spaced sites over that of a pilot's sites whose light the others tell, times the root of the
/// pilot's share of the sites: from 0.06 to 0.17 in the scenes of data/ACCURACY.md.
constexpr double of_left_out = 0.14;
constexpr double surely = 2.0; ///< a requested error over a predicted one, for it to be reached

/// What a pilot bakes: the scene with few rays and the default elements.
BakeOptions pilot_options(const BakeOptions& options) {
    BakeOptions own = options;
    own.rays = pilot_rays(options.rays);
    own.sites = 0; // at spacings of their own
    own.basis.clear();
    own.projection.clear();
    own.transport = BakeOptions().transport;
    own.kernel.clear();
    own.target.reset();
    own.light_groups = false;
    return own;
}

/// Judges a solution whose sites are `spacing` apart: the size of the error around each of them is how far its light is
/// from what the others say.
Judged judged_with(const BakeResult& pilot, std::shared_ptr<const SiteSet> placed, std::vector<double> spacing,
                   const Execution& execution) {
    const Discretisation& discretisation = pilot.system->discretisation();
    const SiteSet& sites = *discretisation.sites;
    const Values h = sum_of_parts(pilot.solution.h, pilot.channels);
    const Values residual = judged_at_sites(pilot, leave_one_out(*discretisation.basis, sites, h, execution));
    const double light = judged_at_sites(pilot, h).norm();
    Judged judged{std::move(placed), std::move(spacing), std::vector<double>(sites.size()),
                  light > 0.0 ? residual.norm() / light : 0.0};
    for (std::size_t i = 0; i < sites.size(); ++i) {
        judged.error[i] = residual.row(static_cast<Eigen::Index>(i)).norm();
    }
    return judged;
}

/// Whether so many evenly spaced sites reach the requested error: then a second pilot is not worth its time.
bool suffice_evenly(const Judged& pilot, double sites, double requested) {
    const double share = static_cast<double>(pilot.sites->size()) / sites;
    return surely * of_left_out * pilot.relative * std::sqrt(share) <= requested;
}

/// The spacing that sites are placed at around each of them.
std::vector<double> placed_spacing(const SiteSet& sites, const SizeField& size) {
    std::vector<double> spacing(sites.size());
    for (std::size_t i = 0; i < sites.size(); ++i) {
        spacing[i] = size.placed_at(sites.points[i].position, sites.region[i]);
    }
    return spacing;
}

} // namespace

std::optional<Judged> judged_by(const BakeResult& result, const Placed& placed, const Execution& execution) {
    const BakeOptions& options = result.options;
    if (!options.basis.empty() || !options.projection.empty() || !options.kernel.empty() ||
        options.transport != BakeOptions().transport) {
        return std::nullopt;
    }
    return judged_with(result, placed.sites,
                       placed.spacing.empty() ? std::vector<double>(placed.sites->size(), placed.sites->spacing)
                                              : placed.spacing,
                       execution);
}

std::optional<Placed> place_adaptively(const BakeResult& result, const Registry& registry, const Choices& choices,
                                       const LitSurface& lit, const Tracer& tracer, const std::optional<Judged>& known,
                                       const Execution& execution) {
    const Mesh& mesh = result.scene->mesh;
    const double largest = result.options.spacing / std::sqrt(pilot_shares.front());
    Journal savings; // of sites on dark surfaces, unless all are placed evenly
    const std::vector<SurfacePoint> even =
        lit_points(result, choices, lit, largest, execution.with(execution.progress, &savings));
    const double all =
        result.options.sites > 0
            ? static_cast<double>(result.options.sites)
            : static_cast<double>(lit_points(result, choices, lit, result.options.spacing, execution.silent()).size());
    if (static_cast<double>(even.size()) > most_even * all) {
        return std::nullopt;
    }
    const double known_sites = known ? static_cast<double>(known->sites->size()) : 0.0;
    std::optional<Judged> judged;
    std::optional<SizeField> size;
    const auto set_of = [&](std::vector<SurfacePoint> points, double spacing) {
        return site_set_of(result, lit, std::move(points), spacing, execution, size ? &*size : nullptr);
    };
    const auto sites_at = [&](double share) {
        std::vector<SurfacePoint> points = even;
        if (size) {
            points = refine_sites(mesh, std::move(points), *size, most_sites_now(execution),
                                  RandomStream(result.options.seed, "graded sites"), Unreported(execution));
        }
        return set_of(std::move(points), result.options.spacing / std::sqrt(share));
    };
    double yield = 1.0; // where spacings change, fewer sites fit than their squares say
    const auto sites_for = [&](double share) {
        if (!judged) {
            return sites_at(share);
        }
        const double target = std::max(static_cast<double>(even.size()), share * all);
        for (int attempt = 1;; ++attempt) {
            size = graded_spacing(*judged->sites, judged->spacing, judged->error, largest, target / yield,
                                  mesh.region_count, execution);
            const std::shared_ptr<SiteSet> sites = sites_at(share);
            const double got = static_cast<double>(sites->size()) / target;
            if (attempt == most_attempts || std::abs(got - 1.0) <= close_enough) {
                return sites;
            }
            yield *= got;
        }
    };
    for (std::size_t k = 0; k < pilot_shares.size(); ++k) {
        if (known_sites >= known_shares[k] * all) {
            judged = known;
        } else {
            execution.phase("pilot bake");
            const std::shared_ptr<SiteSet> sites = sites_for(pilot_shares[k]);
            bake_pilot(result, pilot_options(result.options), registry, choices, {sites, lit.dark_area}, tracer,
                       execution, [&](const BakeResult& pilot, const Execution& own) {
                           judged = judged_with(
                               pilot, sites,
                               size ? placed_spacing(*sites, *size) : std::vector<double>(sites->size(), largest), own);
                       });
        }
        if (judged->sites->graded) {
            continue;
        }
        const std::optional<ErrorTarget>& target = result.options.target;
        const char* const why_even =
            judged->relative < negligible_error           ? "few evenly spaced sites represent the light"
            : gain_of_grading(judged->error) < least_gain ? "the light varies about equally everywhere"
            : target && result.options.goals.empty() && !known && suffice_evenly(*judged, all, target->relative)
                ? "evenly spaced sites are accurate enough"
                : nullptr;
        if (why_even != nullptr) {
            if (known_sites < known_shares.back() * all) {
                execution.save({"graded sites", why_even, "sites of a second pilot bake", pilot_shares.back() * all});
            }
            return std::nullopt;
        }
    }
    if (execution.journal != nullptr) {
        execution.journal->append(savings);
    }
    execution.phase("place sites");
    Placed placed = with_sites_in_sight(result, registry, choices, lit, tracer, sites_for(1.0), execution, set_of);
    placed.spacing = placed_spacing(*placed.sites, *size);
    return placed;
}

} // namespace difusa
