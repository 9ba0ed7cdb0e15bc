// The small steps of the transport phase apart from the rays, each alone: what a ray costs beyond its first hit. Times
// are for all rays of one site, items a second count rays. In a room of 240,000 triangles with 10,000 sites; the points
// at which surfels are looked up, or a basis is evaluated as by a final gather, are those that the rays of sites meet,
// in the order in which they are come by.
#include "setting.h"

#include <difusa/algebra/hit_lists.h>
#include <difusa/discretisation/discretisation.h>
#include <difusa/rays/direction_pool.h>
#include <difusa/rays/directions.h>
#include <difusa/rays/visibility.h>

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <iterator>

namespace {

using namespace difusa;

constexpr std::size_t triangles = 240'000, site_count = 10'000, rays_a_site = 256;
/// So many sites take turns that what they meet does not stay in the first caches.
constexpr std::size_t sample_size = 512;

struct Setting {
    Registry registry = Registry::load();
    Scene scene = bench::make_scene(registry, {}, triangles);
    SiteSet sites = bench::make_sites(registry, scene, site_count, {});
    Surfels surfels = Surfels(scene.mesh, Discretisation::surfel_edge(sites.spacing), Execution{});
    std::shared_ptr<Directions> directions = registry.create<Directions>("low-discrepancy");
    DirectionPool pool = DirectionPool(*directions, rays_a_site, bench::seed);
    std::vector<std::vector<Hit>> met; ///< for each site of the sample, the fronts its rays meet

    Setting() {
        std::string engine = registry.find("visibility", "embree") != nullptr ? "embree" : "cgal";
        const auto visibility = registry.create<Visibility>(engine);
        visibility->build(scene.mesh);
        std::vector<Ray> rays(pool.count());
        std::vector<Hit> hits(pool.count());
        for (std::size_t k = 0; k < sample_size; ++k) {
            const std::size_t j = site_of(k);
            pool.rays(sites.points[j], j, rays);
            visibility->first_hits(rays, hits);
            std::vector<Hit>& fronts = met.emplace_back();
            std::copy_if(hits.begin(), hits.end(), std::back_inserter(fronts),
                         [](const Hit& hit) { return hit.face != none && hit.front; });
        }
    }

    std::size_t site_of(std::size_t sample) const { return sample * sites.size() / sample_size; }
};

/// Runs `work(k)` for the sites of the sample in turn.
template <class Work> void for_each_site(benchmark::State& state, std::size_t rays, const Work& work) {
    std::size_t k = 0;
    for ([[maybe_unused]] auto _ : state) {
        work(k);
        k = (k + 1) % sample_size;
    }
    state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations() * rays));
}

void make_rays(benchmark::State& state, const Setting& setting) {
    std::vector<Ray> rays(setting.pool.count());
    for_each_site(state, rays.size(), [&](std::size_t k) {
        const std::size_t j = setting.site_of(k);
        benchmark::DoNotOptimize(setting.pool.rays(setting.sites.points[j], j, rays));
        benchmark::ClobberMemory();
    });
}

void place_hits(benchmark::State& state, const Setting& setting) {
    for_each_site(state, rays_a_site, [&](std::size_t k) {
        for (const Hit& hit : setting.met[k]) {
            benchmark::DoNotOptimize(setting.scene.mesh.at(hit.face, hit.u, hit.v));
        }
    });
}

void evaluate(benchmark::State& state, const Setting& setting, const std::string& choice) {
    const auto basis = bench::make_basis(setting.registry, choice, setting.scene, setting.sites);
    std::vector<std::vector<SurfacePoint>> points(sample_size);
    for (std::size_t k = 0; k < sample_size; ++k) {
        for (const Hit& hit : setting.met[k]) {
            points[k].push_back(setting.scene.mesh.at(hit.face, hit.u, hit.v));
        }
    }
    BasisRow row;
    std::size_t elements = 0, evaluated = 0;
    for_each_site(state, rays_a_site, [&](std::size_t k) {
        for (const SurfacePoint& x : points[k]) {
            basis->evaluate(x, row);
            elements += row.element.size();
        }
        evaluated += points[k].size();
    });
    state.counters["elements"] = static_cast<double>(elements) / static_cast<double>(evaluated);
}

void look_up_surfels(benchmark::State& state, const Setting& setting) {
    for_each_site(state, rays_a_site, [&](std::size_t k) {
        for (const Hit& hit : setting.met[k]) {
            benchmark::DoNotOptimize(setting.surfels.at(hit.face, hit.u, hit.v));
        }
    });
}

std::vector<std::vector<Index>> bins_of(const Setting& setting) {
    std::vector<std::vector<Index>> bins(sample_size);
    for (std::size_t k = 0; k < sample_size; ++k) {
        for (const Hit& hit : setting.met[k]) {
            bins[k].push_back(setting.surfels.at(hit.face, hit.u, hit.v));
        }
    }
    return bins;
}

/// Sorts and compresses what the rays of a site met.
void list_hits(benchmark::State& state, const Setting& setting) {
    const auto bins = bins_of(setting);
    std::vector<Index> row;
    for_each_site(state, rays_a_site, [&](std::size_t k) {
        HitLists lists(1, setting.surfels.size(), rays_a_site, 1);
        row = bins[k];
        lists.set(0, row);
        benchmark::DoNotOptimize(lists);
    });
}

/// Decodes and sums them, for three channels.
void apply(benchmark::State& state, const Setting& setting) {
    const auto bins = bins_of(setting);
    HitLists lists(sample_size, setting.surfels.size(), rays_a_site, 16);
    for (std::size_t k = 0; k < sample_size; ++k) {
        std::vector<Index> row = bins[k];
        lists.set(k, row);
        if (k % 16 == 15) {
            lists.close_block(k - 15);
        }
    }
    const Values b = Values::Ones(static_cast<Eigen::Index>(setting.surfels.size()), 3);
    Values h;
    for ([[maybe_unused]] auto _ : state) {
        lists.apply(b, h, Execution{});
        benchmark::DoNotOptimize(h.data());
    }
    state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations() * sample_size * rays_a_site));
    state.counters["bytes a ray"] = static_cast<double>(lists.bytes()) / (sample_size * rays_a_site);
}

} // namespace

int main(int argc, char** argv) {
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) {
        return static_cast<int>(ExitCode::usage);
    }
    try {
        const Setting setting;
        const auto add = [&](const std::string& name, const auto& kernel, const auto&... more) {
            benchmark::RegisterBenchmark(name.c_str(), [&setting, kernel, more...](benchmark::State& state) {
                kernel(state, setting, more...);
            })->Unit(benchmark::kMicrosecond);
        };
        add("directions", make_rays);
        add("place hits", place_hits);
        for (const std::string& basis : setting.registry.names("basis")) {
            add("evaluate " + basis, evaluate, basis);
        }
        add("look up surfels", look_up_surfels);
        add("list hits", list_hits);
        add("apply, all sites", apply);
        benchmark::RunSpecifiedBenchmarks();
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "error: %s\n", error.what());
        return static_cast<int>(ExitCode::internal);
    }
}
