#include <difusa/bake/placing.h>

#include <difusa/core/error.h>
#include <difusa/core/memory.h>
#include <difusa/core/text.h>
#include <difusa/discretisation/predict_sites.h>
#include <difusa/lighting/dark_regions.h>

#include <algorithm>
#include <cmath>

namespace difusa {

namespace {

constexpr std::size_t most_sites = std::size_t{1} << 30U;
constexpr std::size_t bytes_of_site = 400; ///< while it is placed and linked to its neighbours

/// The spacing that gives the desired number of sites; sites on dark surfaces will be dropped.
double spacing_for(const BakeResult& result, const Choices& choices, const LitSurface& lit, std::size_t limit,
                   const Execution& execution) {
    const Mesh& mesh = result.scene->mesh;
    const std::size_t wanted = result.options.sites;
    if (wanted > limit) {
        throw ResourceError(std::to_string(wanted) + " sites are requested, but memory suffices for only " +
                            std::to_string(limit) + ": give fewer --sites, or more --max-memory if that is the limit");
    }
    constexpr double most = 50.0; // times the desired number, mostly on dark surfaces
    const double more =
        choices.sampler->needs_visibility() ? 1.0 : std::min(most, mesh.area / (mesh.area - lit.dark_area));
    const double count = std::min(static_cast<double>(limit), more * static_cast<double>(wanted));
    return spacing_for_count(*choices.sampler, mesh, choices.engine.get(), static_cast<std::size_t>(count),
                             result.options.seed, execution);
}

} // namespace

std::size_t most_sites_now(const Execution& execution) {
    const std::size_t sites = std::min(most_sites, execution.memory_left() / bytes_of_site);
    if (sites == 0) {
        throw ResourceError("no memory is left for sites" +
                            (std::isfinite(execution.most_memory)
                                 ? ": the program holds the " + format_bytes(execution.most_memory) +
                                       " that --max-memory allows; allow more"
                                 : std::string()));
    }
    return sites;
}

void choose_spacing(BakeResult& result, const Choices& choices, const LitSurface& lit, const Execution& execution) {
    BakeOptions& options = result.options;
    if (options.spacing == 0.0) {
        options.sites = options.sites == 0 ? default_sites : options.sites;
        options.spacing = spacing_for(result, choices, lit, most_sites_now(execution), execution);
    }
    if (options.output_spacing == 0.0) {
        options.output_spacing = options.output_in_spacings * options.spacing;
    }
}

LitSurface lit_surface(const BakeResult& result, const DirectLight& lights, const Tracer& tracer,
                       const Execution& execution) {
    execution.phase("look for dark surfaces");
    const Scene& scene = *result.scene;
    const Mesh& mesh = scene.mesh;
    LitSurface lit{dark_regions(scene, lights, tracer, result.options.seed, execution), 0.0};
    std::size_t lost = 0; // triangles whose light reaches nothing
    Index first_lost = none;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        if (lit.dark[mesh.region[t]] == 0) {
            continue;
        }
        lit.dark_area += mesh.areas[t];
        if ((scene.materials[mesh.material[t]].emission > 0.0).any()) {
            first_lost = lost++ == 0 ? t : first_lost;
        }
    }
    const bool all_dark = std::find(lit.dark.begin(), lit.dark.end(), 0) == lit.dark.end();
    if (lost > 0 && !all_dark && !scene.thermal) {
        execution.note(std::to_string(lost) + " emitting triangles light nothing, the first in face " +
                       std::to_string(mesh.original_face[first_lost]) + " (material " +
                       scene.materials[mesh.material[first_lost]].name +
                       "): their fronts see the front of no surface; flip them or the faces that they shine on, or "
                       "make their material double-sided");
    }
    // Every surface radiates, at least towards the surroundings: its heat is balanced.
    if (all_dark || result.options.every_surface || scene.thermal) {
        lit.dark.assign(mesh.region_count, 0);
        lit.dark_area = 0.0;
    }
    return lit;
}

std::optional<std::size_t> forecast_sites(BakeResult& result, const Choices& choices, const LitSurface& lit,
                                          const Execution& execution) {
    execution.phase("predict sites");
    choose_spacing(result, choices, lit, execution);
    if (choices.sampler->needs_visibility()) {
        return std::nullopt;
    }
    const Mesh& mesh = result.scene->mesh;
    const std::optional<double> all =
        predict_sites(*choices.sampler, mesh, result.options.spacing, result.options.seed, execution);
    return all ? std::optional(static_cast<std::size_t>(*all * (1.0 - lit.dark_area / mesh.area))) : std::nullopt;
}

std::vector<SurfacePoint> lit_points(const BakeResult& result, const Choices& choices, const LitSurface& lit,
                                     double spacing, const Execution& execution) {
    const Mesh& mesh = result.scene->mesh;
    const BakeOptions& options = result.options;
    std::vector<SurfacePoint> points = choices.sampler->sample(
        mesh, choices.engine.get(), spacing, most_sites_now(execution), RandomStream(options.seed, "sites"), execution);
    const std::size_t all = points.size();
    if (all == 0) {
        throw UsageError("the sampler " + options.sampler + " has placed no sites");
    }
    std::erase_if(points, [&](const SurfacePoint& x) { return lit.dark[mesh.region[x.face]] != 0; });
    if (points.empty()) {
        throw InputError(result.file + ": the observer of the sampler " + options.sampler +
                         " sees only surface that no light reaches: turn it, or use --sampler poisson-disk");
    }
    if (points.size() < all) {
        execution.save({"sites",
                        text_of(std::round(1000.0 * lit.dark_area / mesh.area) / 10.0) +
                            " % of the surface sees nothing that "
                            "emits or reflects light",
                        "sites", static_cast<double>(all - points.size())});
    }
    return points;
}

std::shared_ptr<SiteSet> site_set_of(const BakeResult& result, const LitSurface& lit, std::vector<SurfacePoint> points,
                                     double spacing, const Execution& execution, const SizeField* size) {
    auto sites = std::make_shared<SiteSet>(
        make_site_set(result.scene->mesh, std::move(points), spacing, result.options.neighbours, execution, size));
    sites->graded = size != nullptr;
    if (lit.dark_area > 0.0) {
        sites->dark = lit.dark;
    }
    return sites;
}

std::shared_ptr<SiteSet> place_sites(const BakeResult& result, const Choices& choices, const LitSurface& lit,
                                     const Execution& execution) {
    const double spacing = result.options.spacing;
    return site_set_of(result, lit, lit_points(result, choices, lit, spacing, execution), spacing, execution);
}

} // namespace difusa
