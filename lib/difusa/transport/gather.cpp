#include <difusa/transport/gather.h>

#include <difusa/core/parallel.h>
#include <difusa/rays/surroundings.h>

#include <algorithm>
#include <memory>

namespace difusa {

namespace {

/// What one thread needs to serve a point.
struct Worker {
    Surroundings around;
    std::vector<BasisRow> rows;
    RowAccumulator elements, emitters;
    std::vector<RowAccumulator> uneven; ///< one for each channel
    FirstBounce::Worker light;
    Worker(const Mesh& mesh, const Visibility& visibility, const DirectionPool& pool, std::size_t element_count,
           std::size_t material_count)
        : around(mesh, visibility, pool), rows(pool.count()), elements(element_count), emitters(material_count),
          uneven(3, emitters) {}
};

void add_elements(const Basis& basis, Worker& work) {
    const std::span<const SurfacePoint> met = work.around.points();
    const std::span<const double> weight = work.around.weights();
    basis.evaluate(met, work.rows);
    for (std::size_t p = 0; p < met.size(); ++p) {
        const BasisRow& row = work.rows[p];
        for (std::size_t i = 0; i < row.element.size(); ++i) {
            work.elements.add(row.element[i], weight[p] * row.weight[i]);
        }
    }
}

void add_emitters(const Scene& scene, const std::vector<char>& emits, Worker& work) {
    const std::span<const SurfacePoint> met = work.around.points();
    const std::span<const double> weight = work.around.weights();
    for (std::size_t p = 0; p < met.size(); ++p) {
        const Index material = scene.mesh.material[met[p].face];
        if (emits[material] != 0 && !scene.materials[material].emits_unevenly()) {
            work.emitters.add(material, weight[p]);
        } else if (emits[material] != 0) {
            const Rgb E = scene.emission(met[p]);
            for (std::size_t c = 0; c < 3; ++c) {
                work.uneven[c].add(material, weight[p] * E[static_cast<Eigen::Index>(c)]);
            }
        }
    }
}

/// What escapes and what meets backs, of point j.
void put_rest(const Scene& scene, const Surroundings& around, std::size_t j, Transport& transport) {
    transport.sky[j] = around.sky();
    transport.back[j] = around.back();
    if (scene.dome) {
        transport.dome.row(static_cast<Eigen::Index>(j)) = dome_irradiance(scene, around).matrix().transpose();
    }
}

void prepare_rest(const Scene& scene, std::size_t points, Transport& transport) {
    transport.sky.assign(points, 0.0);
    transport.back.assign(points, 0.0);
    if (scene.dome) {
        transport.dome.setZero(static_cast<Eigen::Index>(points), 3);
    }
}

} // namespace

Transport gather(const Scene& scene, std::span<const SurfacePoint> points, const Basis& basis,
                 const Visibility& visibility, const Directions& directions, std::size_t rays, std::uint64_t seed,
                 const Execution& execution, const Sources& sources) {
    const DirectionPool pool(directions, rays, seed);
    std::vector<char> emits = emitting_materials(scene);
    for (std::size_t m = 0; m < sources.lamps.size(); ++m) {
        emits[m] = sources.lamps[m] != 0 ? 0 : emits[m];
    }
    const bool any_emits = std::find(emits.begin(), emits.end(), 1) != emits.end();
    const bool uneven = any_emits && has_uneven_emitters(scene);
    const auto count = static_cast<Eigen::Index>(points.size());
    Transport transport;
    transport.S = SparseRows(points.size(), basis.size());
    transport.L = SparseRows(points.size(), scene.materials.size());
    if (uneven) {
        transport.uneven.fill(transport.L);
    }
    prepare_rest(scene, points.size(), transport);
    transport.rays = points.size() * pool.count();
    transport.bounce.assign(sources.bounce.size(), Values::Zero(count, sources.channels));

    std::vector<std::unique_ptr<Worker>> workers(execution.threads);
    // A range of a few thousand rays: short enough to stop soon when asked to.
    const std::size_t grain = std::clamp<std::size_t>(4096 / pool.count(), 1, 16);
    parallel_for(points.size(), grain, execution, [&](std::size_t begin, std::size_t end, unsigned number) {
        if (!workers[number]) {
            workers[number] =
                std::make_unique<Worker>(scene.mesh, visibility, pool, basis.size(), scene.materials.size());
        }
        Worker& work = *workers[number];
        for (std::size_t j = begin; j < end; ++j) {
            work.around.look(points[j], j);
            put_rest(scene, work.around, j, transport);
            add_elements(basis, work);
            work.elements.take(transport.S.row(j));
            if (any_emits) {
                add_emitters(scene, emits, work);
                work.emitters.take(transport.L.row(j));
                for (std::size_t c = 0; uneven && c < 3; ++c) {
                    work.uneven[c].take(transport.uneven[c].row(j));
                }
            }
            for (std::size_t g = 0; g < sources.bounce.size(); ++g) {
                RandomStream stream(seed, "first bounce", j);
                transport.bounce[g].row(static_cast<Eigen::Index>(j)) =
                    sources.bounce[g]
                        ->irradiance(points[j], work.around.points(), work.around.weights(), pool.count(), stream,
                                     work.light)
                        .head(sources.channels)
                        .matrix()
                        .transpose();
            }
        }
    });
    DirectLight::Effort effort;
    for (const auto& worker : workers) {
        if (worker) {
            effort.add(worker->light.light);
        }
    }
    transport.segments = effort.segments;
    return transport;
}

void gather_sky(const Scene& scene, std::span<const SurfacePoint> points, const Visibility& visibility,
                const Directions& directions, std::size_t rays, std::uint64_t seed, const Execution& execution,
                Transport& transport) {
    const DirectionPool pool(directions, rays, seed);
    prepare_rest(scene, points.size(), transport);
    transport.rays += points.size() * pool.count();
    parallel_for(points.size(), 16, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        Surroundings around(scene.mesh, visibility, pool);
        for (std::size_t j = begin; j < end; ++j) {
            around.look(points[j], j);
            put_rest(scene, around, j, transport);
        }
    });
}

} // namespace difusa
