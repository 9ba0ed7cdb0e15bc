#include <difusa/transport/gather.h>

#include <difusa/core/parallel.h>
#include <difusa/transport/surroundings.h>

#include <algorithm>
#include <memory>

namespace difusa {

namespace {

/// What one thread needs to serve a point.
struct Worker {
    Surroundings around;
    std::vector<BasisRow> rows;
    RowAccumulator elements, emitters;
    DirectLight::Worker light;
    std::vector<Rgb> H;
    Worker(const Mesh& mesh, const Visibility& visibility, const DirectionPool& pool, std::size_t element_count,
           std::size_t material_count)
        : around(mesh, visibility, pool), rows(pool.count()), elements(element_count), emitters(material_count),
          H(pool.count()) {}
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
        if (emits[material] != 0) {
            work.emitters.add(material, weight[p] * scene.emission_factor(met[p]));
        }
    }
}

Rgb reflect(const Scene& scene, const DirectLight& light, RandomStream& stream, Worker& work) {
    const std::span<const SurfacePoint> met = work.around.points();
    const std::span<const double> weight = work.around.weights();
    light.sample(met, stream, std::span(work.H).first(met.size()), work.light);
    Rgb sum = Rgb::Zero();
    for (std::size_t p = 0; p < met.size(); ++p) {
        sum += weight[p] * scene.reflectance(met[p]) * work.H[p];
    }
    return sum;
}

} // namespace

Transport gather(const Scene& scene, std::span<const SurfacePoint> points, const Basis& basis,
                 const Visibility& visibility, const Directions& directions, std::size_t rays, std::uint64_t seed,
                 const Execution& execution, const FirstBounce* bounce) {
    const DirectionPool pool(directions, rays, seed);
    const std::vector<char> emits = emitting_materials(scene);
    const bool reflects = bounce != nullptr && bounce->light->any();
    const bool any_emits =
        std::find(emits.begin(), emits.end(), 1) != emits.end() && !(reflects && bounce->light->has_lamps());
    Transport transport;
    transport.S = SparseRows(points.size(), basis.size());
    transport.L = SparseRows(points.size(), scene.materials.size());
    transport.sky.assign(points.size(), 0.0);
    transport.back.assign(points.size(), 0.0);
    transport.rays = points.size() * pool.count();
    if (reflects) {
        transport.bounce.setZero(static_cast<Eigen::Index>(points.size()), bounce->channels);
    }

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
            transport.sky[j] = work.around.sky();
            transport.back[j] = work.around.back();
            add_elements(basis, work);
            work.elements.take(transport.S.row(j));
            if (any_emits) {
                add_emitters(scene, emits, work);
                work.emitters.take(transport.L.row(j));
            }
            if (reflects) {
                RandomStream stream(seed, "first bounce", j);
                transport.bounce.row(static_cast<Eigen::Index>(j)) =
                    reflect(scene, *bounce->light, stream, work).head(bounce->channels).matrix().transpose();
            }
        }
    });
    for (const auto& worker : workers) {
        transport.segments += worker ? worker->light.cast + worker->light.lamps.cast : 0;
    }
    return transport;
}

void gather_sky(const Scene& scene, std::span<const SurfacePoint> points, const Visibility& visibility,
                const Directions& directions, std::size_t rays, std::uint64_t seed, const Execution& execution,
                Transport& transport) {
    const DirectionPool pool(directions, rays, seed);
    transport.sky.assign(points.size(), 0.0);
    transport.back.assign(points.size(), 0.0);
    transport.rays += points.size() * pool.count();
    parallel_for(points.size(), 16, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        Surroundings around(scene.mesh, visibility, pool);
        for (std::size_t j = begin; j < end; ++j) {
            around.look(points[j], j);
            transport.sky[j] = around.sky();
            transport.back[j] = around.back();
        }
    });
}

} // namespace difusa
