#include <difusa/bake/subdivided_patches.h>

#include <difusa/bake/pilot.h>
#include <difusa/discretisation/subdivision.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace difusa {

namespace {

constexpr double least_miss = 1e-6; ///< of the rms of the light

bool is_dark(const Mesh& mesh, const LitSurface& lit, const PatchMesh& patches, Index patch) {
    return lit.dark[mesh.region[patches.parent(patch)]] != 0;
}

/// What a pilot bakes: the scene with few rays.
BakeOptions patch_pilot_options(const BakeOptions& options) {
    BakeOptions own = options;
    own.rays = pilot_rays(options.rays);
    own.sites = 0; // of which there are enough already
    own.light_groups = false;
    own.keep_iterates = false;
    return own;
}

} // namespace

Placed place_elements(const BakeResult& result, const Registry& registry, const Choices& choices, const LitSurface& lit,
                      const Tracer& tracer, const Execution& execution) {
    const BakeOptions& options = result.options;
    const Mesh& mesh = result.scene->mesh;
    const Execution silent = execution.silent();
    const std::size_t most = most_sites_now(execution);
    const auto lit_patches = [&](const PatchMesh& patches) {
        std::size_t count = 0;
        for (Index f = 0; f < patches.size(); ++f) {
            count += is_dark(mesh, lit, patches, f) ? 0 : 1;
        }
        return count;
    };
    const PatchMesh patches(mesh, PatchMesh::edge_for_patches(PatchElements::coarseness * options.spacing), most,
                            silent);
    const std::size_t to_begin_with = lit_patches(patches);
    const std::size_t wanted =
        options.sites > 0 ? options.sites
                          : lit_patches(PatchMesh(mesh, PatchMesh::edge_for_patches(options.spacing), most, silent));
    const std::size_t without_sites = patches.size() - to_begin_with;
    const auto between = static_cast<std::size_t>(
        std::sqrt(static_cast<double>(to_begin_with) * static_cast<double>(std::max(wanted, to_begin_with))));

    PatchElements elements(patches);
    const auto sites_now = [&] {
        std::vector<SurfacePoint> points;
        for (const Index node : elements.elements()) {
            if (!is_dark(mesh, lit, patches, elements.patch(node))) {
                points.push_back(elements.centre(node));
            }
        }
        std::shared_ptr<SiteSet> sites = site_set_of(result, lit, std::move(points), options.spacing, execution);
        sites->graded = true;
        return sites;
    };
    for (const std::size_t target : {between, wanted}) {
        execution.phase("pilot bake");
        const std::shared_ptr<SiteSet> sites = sites_now();
        bake_pilot(result, patch_pilot_options(options), registry, choices, {sites, lit.dark_area}, tracer, execution,
                   [&](const BakeResult& pilot, const Execution& own) {
                       const Values light = judged_at_sites(pilot, sum_of_parts(pilot.solution.h, pilot.channels));
                       elements = PatchElements(patches, sites->points);
                       const double rms = std::sqrt(light.squaredNorm() / static_cast<double>(sites->size()));
                       const SubdivisionLimits limits{target + without_sites, options.levels.value_or(default_levels),
                                                      std::pow(least_miss * rms, 2)};
                       quarter_worst(elements, squared_misses(elements, *sites, light, own), limits);
                   });
    }
    execution.phase("place sites");
    return {sites_now(), lit.dark_area};
}

} // namespace difusa
