#include <difusa/radiosity/field.h>

#include <difusa/core/parallel.h>
#include <difusa/discretisation/evaluate.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/rays/surroundings.h>

#include <algorithm>
#include <memory>

namespace difusa {

Irradiance Field::evaluate(std::span<const SurfacePoint> x, std::uint64_t seed, std::string_view purpose,
                           const Execution& execution) const {
    Irradiance H;
    Values both(parts_.smooth.rows(), 2 * parts_.smooth.cols());
    both << parts_.soft_direct, parts_.smooth;
    std::vector<SurfacePoint> inside;
    inside.reserve(x.size());
    for (const SurfacePoint& point : x) {
        inside.push_back(inset(parts_.scene->mesh, point));
    }
    const Values h = difusa::evaluate(*parts_.basis, both, inside, execution);
    const Eigen::Index c = channels();
    H.direct = h.leftCols(c);
    H.indirect = h.rightCols(c) - H.direct;
    if (!parts_.direct_in_basis) {
        DirectLight::Effort effort;
        H.direct += parts_.direct->irradiance(x, channels(), parts_.lamp_samples, seed, purpose, execution, effort);
        H.segments = effort.segments;
        H.clear = effort.clear;
    }
    return H;
}

Irradiance Field::gather(std::span<const SurfacePoint> x, std::size_t rays, std::uint64_t seed,
                         std::string_view purpose, const Execution& execution) const {
    struct Worker {
        Surroundings around;
        FirstBounce::Worker light;
        std::vector<BasisRow> rows;
    };
    const Scene& scene = *parts_.scene;
    const DirectLight& light = *parts_.direct;
    const bool emits = scene.has_emitters();
    const std::vector<char>& lamps = light.lamp_materials();
    const auto channel_count = static_cast<Eigen::Index>(channels());
    // A seed of its own: the directions must not be those of the sites.
    const std::uint64_t own_seed = RandomStream(seed, purpose).bits();
    const DirectionPool pool(*parts_.directions, rays, own_seed);
    Irradiance result;
    DirectLight::Effort effort;
    result.direct = light.irradiance(x, channels(), parts_.lamp_samples, seed, purpose, execution, effort);
    result.indirect.setZero(static_cast<Eigen::Index>(x.size()), channel_count);
    result.rays = x.size() * pool.count();
    std::vector<std::unique_ptr<Worker>> workers(execution.threads);
    const std::size_t grain = std::clamp<std::size_t>(4096 / pool.count(), 1, 16);
    parallel_for(x.size(), grain, execution, [&](std::size_t begin, std::size_t end, unsigned number) {
        if (!workers[number]) {
            workers[number] = std::make_unique<Worker>(
                Worker{Surroundings(scene.mesh, *parts_.visibility, pool), {}, std::vector<BasisRow>(pool.count())});
        }
        Worker& work = *workers[number];
        for (std::size_t i = begin; i < end; ++i) {
            work.around.look(x[i], i);
            const std::span<const SurfacePoint> met = work.around.points();
            const std::span<const double> weight = work.around.weights();
            parts_.basis->evaluate(met, work.rows);
            Rgb sky = Rgb::Zero();
            if (parts_.group.sky) {
                sky = work.around.sky() * scene.sky + dome_irradiance(scene, work.around);
            }
            Eigen::RowVectorXd direct = sky.head(channel_count).matrix().transpose();
            Eigen::RowVectorXd indirect = Eigen::RowVectorXd::Zero(channel_count);
            if (parts_.bounce) {
                RandomStream stream(own_seed, "bounce", i);
                const Rgb bounced = parts_.bounce->irradiance(x[i], met, weight, pool.count(), stream, work.light);
                indirect = bounced.head(channel_count).matrix().transpose();
            }
            Eigen::RowVectorXd H(channel_count);
            for (std::size_t p = 0; p < met.size(); ++p) {
                H.setZero();
                const BasisRow& row = work.rows[p];
                for (std::size_t k = 0; k < row.element.size(); ++k) {
                    H += row.weight[k] * parts_.smooth.row(static_cast<Eigen::Index>(row.element[k]));
                }
                const Rgb rho = scene.reflectance(met[p]);
                indirect += weight[p] * H.cwiseProduct(rho.head(channel_count).matrix().transpose());
                if (emits && lamps[scene.mesh.material[met[p].face]] == 0) {
                    direct +=
                        weight[p] * emission(scene, parts_.group, met[p]).head(channel_count).matrix().transpose();
                }
            }
            result.direct.row(static_cast<Eigen::Index>(i)) += direct;
            result.indirect.row(static_cast<Eigen::Index>(i)) = indirect;
        }
    });
    for (const auto& worker : workers) {
        if (worker) {
            effort.add(worker->light.light);
        }
    }
    result.segments = effort.segments;
    result.clear = effort.clear;
    return result;
}

Values Field::radiosity(std::span<const SurfacePoint> x, const Values& H) const {
    Values B(H.rows(), H.cols());
    for (Eigen::Index i = 0; i < H.rows(); ++i) {
        const SurfacePoint& point = x[static_cast<std::size_t>(i)];
        const Eigen::ArrayXd E = emission(*parts_.scene, parts_.group, point).head(H.cols());
        const Eigen::ArrayXd rho = parts_.scene->reflectance(point).head(H.cols());
        B.row(i) = (E + rho * H.row(i).transpose().array()).matrix().transpose();
    }
    return B;
}

} // namespace difusa
