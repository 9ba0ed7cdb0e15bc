#include <difusa/study/gloss_study.h>

#include <difusa/bake.h>
#include <difusa/core/parallel.h>
#include <difusa/import/shapes.h>
#include <difusa/mesh/surface_sampling.h>
#include <difusa/study/split_square.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>

namespace difusa {

namespace {

constexpr std::size_t judged_places = 64, paths_to_each = 65536, gather_rays = 2048;

} // namespace

Scene glossy_room(const LobeShape& shape, const Rgb& gloss) {
    const double x = 4.0, y = 3.0, z = 2.5;
    Scene scene;
    scene.mesh = rectangle(Vec3::Zero(), Vec3(x, 0, 0), Vec3(0, y, 0));
    add(scene.mesh, rectangle(Vec3(0, 0, z), Vec3(0, y, 0), Vec3(x, 0, 0)), 1);
    add(scene.mesh, rectangle(Vec3::Zero(), Vec3(0, 0, z), Vec3(x, 0, 0)), 1);
    add(scene.mesh, rectangle(Vec3(0, y, 0), Vec3(x, 0, 0), Vec3(0, 0, z)), 1);
    add(scene.mesh, rectangle(Vec3::Zero(), Vec3(0, y, 0), Vec3(0, 0, z)), 2);
    add(scene.mesh, rectangle(Vec3(x, 0, 0), Vec3(0, 0, z), Vec3(0, y, 0)), 3);
    add(scene.mesh, rectangle(Vec3(0.8, 1.0, 2.49), Vec3(0, 0.6, 0), Vec3(0.6, 0, 0)), 4);
    const std::array<Rgb, 5> rho{Rgb(0.1, 0.1, 0.1), Rgb(0.7, 0.7, 0.7), Rgb(0.6, 0.1, 0.1), Rgb(0.1, 0.5, 0.1),
                                 Rgb(0, 0, 0)};
    const std::array<const char*, 5> names{"floor", "walls", "red", "green", "lamp"};
    for (std::size_t m = 0; m < rho.size(); ++m) {
        Material material;
        material.name = names[m];
        material.reflectance = rho[m];
        scene.materials.push_back(material);
    }
    scene.materials[0].gloss = Gloss{shape, gloss};
    scene.materials[4].emission = Rgb(40, 40, 36);
    return scene;
}

TracedRoom::TracedRoom(const Registry& registry, const Scene& scene, std::size_t places, std::size_t paths,
                       std::uint64_t seed, const Execution& execution)
    : places_(even_points(scene.mesh, places, RandomStream(seed, "judged"))), light_(places_.size()) {
    const auto engine = registry.create<Visibility>("cgal");
    engine->build(scene.mesh);
    parallel_for(places_.size(), 1, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t i = begin; i < end; ++i) {
            for (std::size_t half = 0; half < 2; ++half) {
                light_[i][half] = trace_paths(scene, *engine, places_[i], (paths + 1) / 2,
                                              RandomStream(seed, half == 0 ? "first paths" : "second paths", i));
            }
        }
    });
}

TracedRoom::Judgement TracedRoom::judge(const Values& H) const {
    SplitSquare square;
    for (std::size_t i = 0; i < light_.size(); ++i) {
        const auto& [one, other] = light_[i];
        const Vec3 h = H.row(static_cast<Eigen::Index>(i)).transpose();
        square.add(h - one.mean.matrix(), one.covariance, h - other.mean.matrix(), other.covariance);
    }
    const double all = H.squaredNorm();
    return {square.sum() / all, square.deviation() / all};
}

std::vector<GlossTrial> gloss_study(const Registry& registry, std::size_t sites, std::uint64_t seed,
                                    const Execution& execution, const std::function<void(const GlossTrial&)>& tell) {
    using Model = LobeShape::Model;
    std::vector<GlossTrial> trials;
    for (const LobeShape shape :
         {LobeShape{Model::phong, 10.0}, LobeShape{Model::phong, 50.0}, LobeShape{Model::phong, 200.0},
          LobeShape{Model::ggx, 0.5}, LobeShape{Model::ggx, 0.3}}) {
        Scene scene = glossy_room(shape);
        settle_gloss(scene);
        const TracedRoom traced(registry, scene, judged_places, paths_to_each, seed, execution);
        for (const int order : {0, 2, 4, 8, 12, 16}) {
            BakeOptions options;
            options.sites = sites;
            options.seed = seed;
            options.directional_order = order;
            options.output_spacing = 1.0;
            const auto begin = std::chrono::steady_clock::now();
            const BakeResult result = bake(registry, scene, "room", options, execution);
            GlossTrial trial;
            trial.shape = shape;
            trial.order = order;
            trial.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
            trial.resolved = result.glossy->resolved;
            trial.told = result.error->total.rms / result.error->reflected;
            trial.told_at_most = result.error->total.high / result.error->reflected;
            trial.basis = traced.judge(result.field().at(traced.places(), 0, seed, "judged", execution).H);
            trial.gather = traced.judge(result.field().at(traced.places(), gather_rays, seed, "judged", execution).H);
            trials.push_back(trial);
            tell(trial);
        }
    }
    return trials;
}

std::string gloss_header() {
    return "| lobe | order | of the lobe | basis | final gather | estimated | at most | seconds |\n"
           "|---|---|---|---|---|---|---|---|\n";
}

std::string gloss_row(const GlossTrial& trial) {
    const auto error = [](const TracedRoom::Judgement& judgement) {
        char text[48];
        const double root = 100.0 * std::sqrt(std::max(0.0, judgement.squared));
        // Of the root of what is at least as uncertain as large, only a limit is known.
        if (judgement.squared < 2.0 * judgement.deviation) {
            std::snprintf(text, sizeof text, "< %.1f %%",
                          100.0 * std::sqrt(std::max(0.0, judgement.squared) + 2.0 * judgement.deviation));
        } else {
            std::snprintf(text, sizeof text, "%.1f %%", root);
        }
        return std::string(text);
    };
    char row[256];
    std::snprintf(row, sizeof row, "| %s %g | %d | %.0f %% | %s | %s | %.1f %% | %.1f %% | %.1f |\n",
                  trial.shape.model == LobeShape::Model::phong ? "Phong" : "GGX", trial.shape.sharpness, trial.order,
                  100.0 * trial.resolved, error(trial.basis).c_str(), error(trial.gather).c_str(), 100.0 * trial.told,
                  100.0 * trial.told_at_most, trial.seconds);
    return row;
}

} // namespace difusa
