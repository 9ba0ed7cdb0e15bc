#include <difusa/bake/sites_in_sight.h>

#include <difusa/core/parallel.h>
#include <difusa/core/text.h>
#include <difusa/discretisation/point_basis.h>
#include <difusa/discretisation/site_grid.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/rays/glance.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

namespace difusa {

namespace {

constexpr std::size_t places_per_site = 8;
constexpr std::size_t most_rounds = 4;
constexpr double many = 1e-3; ///< of the places that are examined

/// Those of the places that light reaches, but no element of the basis.
std::vector<SurfacePoint> missing(const PointBasis& basis, const Tracer& tracer,
                                  const std::vector<SurfacePoint>& places, std::uint64_t seed,
                                  const Execution& execution) {
    std::vector<std::uint8_t> lacks(places.size(), 0);
    parallel_for(places.size(), 256, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t i = begin; i < end; ++i) {
            RandomStream stream(seed, "pockets", i);
            lacks[i] = !basis.reaches(places[i]) && Glance(tracer, places[i], stream).light_arrives() ? 1 : 0;
        }
    });
    std::vector<SurfacePoint> found;
    for (std::size_t i = 0; i < places.size(); ++i) {
        if (lacks[i] != 0) {
            found.push_back(places[i]);
        }
    }
    return found;
}

} // namespace

Placed with_sites_in_sight(
    const BakeResult& result, const Registry& registry, const Choices& choices, const LitSurface& lit,
    const Tracer& tracer, std::shared_ptr<SiteSet> sites, const Execution& execution,
    const std::function<std::shared_ptr<SiteSet>(std::vector<SurfacePoint> points, double spacing)>& remake) {
    Placed placed{std::move(sites), lit.dark_area};
    const Mesh& mesh = result.scene->mesh;
    const BakeOptions& options = result.options;
    if (mesh.convex || choices.pairwise || !choices.sampler->covers_evenly() ||
        dynamic_cast<const PointBasis*>(choices.elements.basis.get()) == nullptr) {
        return placed;
    }
    const Unreported unreported(execution);
    const std::size_t given = placed.sites->size();
    const auto draw = [&](std::size_t round) {
        std::vector<SurfacePoint> places =
            even_points(mesh, places_per_site * given, RandomStream(options.seed, "places in sight", round));
        std::erase_if(places, [&](const SurfacePoint& x) { return lit.dark[mesh.region[x.face]] != 0; });
        for (SurfacePoint& x : places) {
            x = inset(mesh, x);
        }
        return places;
    };
    // Where most regions have a single site, the spacing says little.
    const double spacing = std::min(options.spacing, std::sqrt(mesh.area / static_cast<double>(given)));
    std::size_t most = std::min(2 * given, most_sites_now(execution));
    if (options.target) {
        most = std::min(most, options.target->most_sites);
    }
    most = std::max(most, given);
    std::vector<SurfacePoint> places;
    bool draw_more = true;
    for (std::size_t round = 0;; ++round) {
        placed.basis = registry.create<Basis>(choices.elements.basis_text);
        placed.basis->bind(mesh, *placed.sites, unreported);
        if (round == most_rounds || placed.sites->size() == most) {
            break;
        }
        if (draw_more) {
            const std::vector<SurfacePoint> further = draw(round);
            places.insert(places.end(), further.begin(), further.end());
        }
        const std::size_t examined = places.size();
        places = missing(dynamic_cast<const PointBasis&>(*placed.basis), tracer, places, options.seed, unreported);
        if (places.empty()) {
            break;
        }
        draw_more = static_cast<double>(places.size()) > many * static_cast<double>(examined); // others were not hit
        std::vector<Dart> darts;
        for (const SurfacePoint& x : places) {
            darts.push_back({x, darts.size()});
        }
        SiteGrid grid(mesh, 0.5 * spacing, most_sites_now(execution));
        grid.insert(darts, unreported);
        std::vector<SurfacePoint> points = placed.sites->points;
        const std::size_t added = std::min(grid.sites().size(), most - points.size());
        points.insert(points.end(), grid.sites().begin(), grid.sites().begin() + static_cast<std::ptrdiff_t>(added));
        placed.sites = remake(std::move(points), spacing);
    }
    if (placed.sites->size() > given) {
        execution.note(counted(placed.sites->size() - given, "site") +
                       " added on lit surface that no other site is in sight of");
    }
    return placed;
}

} // namespace difusa
