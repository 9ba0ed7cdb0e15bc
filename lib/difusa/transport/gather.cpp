#include <difusa/transport/gather.h>

#include <difusa/core/parallel.h>
#include <difusa/transport/direction_pool.h>

#include <algorithm>
#include <memory>

namespace difusa {

namespace {

/// What one thread needs to serve a site.
struct Worker {
    std::vector<Ray> rays;
    std::vector<Hit> hits;
    std::vector<SurfacePoint> points; ///< what the rays met on a front
    std::vector<double> weights;      ///< and their weights
    std::vector<BasisRow> rows;
    RowAccumulator sites, lamps;
    Worker(std::size_t count, std::size_t site_count, std::size_t material_count)
        : rays(count), hits(count), rows(count), sites(site_count), lamps(material_count) {}
};

} // namespace

Transport gather(const Scene& scene, const SiteSet& sites, const Basis& basis, const Visibility& visibility,
                 const Directions& directions, std::size_t rays, std::uint64_t seed, const Execution& execution) {
    const Mesh& mesh = scene.mesh;
    const DirectionPool pool(directions, rays, seed);
    const std::vector<char> emits = emitting_materials(scene);
    const bool any_emits = std::find(emits.begin(), emits.end(), 1) != emits.end();
    Transport transport;
    transport.S = SparseRows(sites.size(), basis.size());
    transport.L = SparseRows(sites.size(), scene.materials.size());
    transport.sky.assign(sites.size(), 0.0);
    transport.back.assign(sites.size(), 0.0);
    transport.rays = sites.size() * pool.count();

    std::vector<std::unique_ptr<Worker>> workers(execution.threads);
    // A range of a few thousand rays: short enough to stop soon when asked to.
    const std::size_t grain = std::clamp<std::size_t>(4096 / pool.count(), 1, 16);
    parallel_for(sites.size(), grain, execution, [&](std::size_t begin, std::size_t end, unsigned number) {
        if (!workers[number]) {
            workers[number] = std::make_unique<Worker>(pool.count(), basis.size(), scene.materials.size());
        }
        Worker& work = *workers[number];
        for (std::size_t j = begin; j < end; ++j) {
            const std::span<const double> weight = pool.rays(sites.points[j], j, work.rays);
            visibility.first_hits(work.rays, work.hits);
            work.points.clear();
            work.weights.clear();
            for (std::size_t d = 0; d < work.hits.size(); ++d) {
                const Hit& hit = work.hits[d];
                if (hit.face == none) {
                    transport.sky[j] += weight[d];
                } else if (!hit.front) {
                    transport.back[j] += weight[d];
                } else {
                    work.points.push_back(mesh.at(hit.face, hit.u, hit.v));
                    work.weights.push_back(weight[d]);
                }
            }
            basis.evaluate(work.points, work.rows);
            for (std::size_t p = 0; p < work.points.size(); ++p) {
                const BasisRow& row = work.rows[p];
                for (std::size_t i = 0; i < row.element.size(); ++i) {
                    work.sites.add(row.element[i], work.weights[p] * row.weight[i]);
                }
            }
            if (any_emits) {
                for (std::size_t p = 0; p < work.points.size(); ++p) {
                    const Index material = mesh.material[work.points[p].face];
                    if (emits[material] != 0) {
                        work.lamps.add(material, work.weights[p]);
                    }
                }
            }
            work.sites.take(transport.S.row(j));
            work.lamps.take(transport.L.row(j));
        }
    });
    return transport;
}

void gather_sky(const SiteSet& sites, const Visibility& visibility, const Directions& directions, std::size_t rays,
                std::uint64_t seed, const Execution& execution, Transport& transport) {
    const DirectionPool pool(directions, rays, seed);
    transport.sky.assign(sites.size(), 0.0);
    transport.back.assign(sites.size(), 0.0);
    transport.rays += sites.size() * pool.count();
    parallel_for(sites.size(), 16, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        std::vector<Ray> batch(pool.count());
        std::vector<Hit> hits(pool.count());
        for (std::size_t j = begin; j < end; ++j) {
            const std::span<const double> weight = pool.rays(sites.points[j], j, batch);
            visibility.first_hits(batch, hits);
            for (std::size_t d = 0; d < hits.size(); ++d) {
                if (hits[d].face == none) {
                    transport.sky[j] += weight[d];
                } else if (!hits[d].front) {
                    transport.back[j] += weight[d];
                }
            }
        }
    });
}

} // namespace difusa
