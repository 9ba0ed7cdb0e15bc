// How fast is a surface lit again? The emission of a room's lamp, with all bounces, by the responses to its lights and
// by a rendering operator of low rank, against the iteration; many lights at once against one after the other; a sun
// that has moved; and the rays of a small crate that has moved in a hall, against all rays.
//
//     relight_bench [--mesh FILE] [--sites 10000] [--rays 512] [--lights 64] [--rank 16] [--repeat 5]
//
// --rank 0 leaves out the operator of low rank, which takes long to form.
// Prints Markdown: medians, of wall and of processor times (of all threads), because other work may load the machine.
// Ratios are of processor times of runs that take turns.
#include "../meshes.h"

#include <difusa/bake.h>
#include <difusa/core/random.h>
#include <difusa/mesh/rigid_motion.h>
#include <difusa/plugin/registry.h>
#include <difusa/radiosity/light_responses.h>
#include <difusa/radiosity/rendering_operator.h>
#include <difusa/radiosity/response.h>
#include <difusa/rays/unfolded_visibility.h>
#include <difusa/rays/visibility_choice.h>
#include <difusa/transport/recast.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace {

using namespace difusa;

struct Options {
    std::string mesh = "data/room_a.json";
    std::size_t sites = 10'000, rays = 512, lights = 64, rank = 16, repeat = 5;

    Options(int argc, char** argv) {
        const std::map<std::string, std::size_t*> counts{
            {"--sites", &sites}, {"--rays", &rays}, {"--lights", &lights}, {"--rank", &rank}, {"--repeat", &repeat}};
        for (int i = 1; i < argc; i += 2) {
            const std::string option = argv[i], text = i + 1 < argc ? argv[i + 1] : "";
            if (option == "--mesh" && !text.empty()) {
                mesh = text;
                continue;
            }
            std::size_t count = 0;
            const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
            if (!counts.contains(option) || error != std::errc() || end != text.data() + text.size() ||
                (count == 0 && option != "--rank")) {
                throw UsageError(option + " " + text +
                                 ": options are --mesh FILE, --sites N, --rays N, --lights N, --rank N, --repeat N");
            }
            *counts.at(option) = count;
        }
    }
};

/// Wall time and processor time of all threads, in seconds.
struct Time {
    double wall = 0.0, processor = 0.0;
};

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

Time measure(const std::function<void()>& work) {
    const auto wall_before = std::chrono::steady_clock::now();
    const std::clock_t before = std::clock();
    work();
    const std::clock_t after = std::clock();
    return {std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_before).count(),
            static_cast<double>(after - before) / CLOCKS_PER_SEC};
}

/// Medians over runs that take turns, after one that warms up.
std::vector<Time> measure_in_turns(std::size_t repeat, const std::vector<std::function<void()>>& works) {
    std::vector<std::vector<double>> wall(works.size()), processor(works.size());
    for (std::size_t i = 0; i <= repeat; ++i) {
        for (std::size_t w = 0; w < works.size(); ++w) {
            const Time time = measure(works[w]);
            if (i > 0) {
                wall[w].push_back(time.wall);
                processor[w].push_back(time.processor);
            }
        }
    }
    std::vector<Time> medians;
    for (std::size_t w = 0; w < works.size(); ++w) {
        medians.push_back({median(wall[w]), median(processor[w])});
    }
    return medians;
}

void print_row(const char* what, const Time& time) {
    std::printf("| %s | %.2f | %.2f |\n", what, 1e3 * time.wall, 1e3 * time.processor);
    std::fflush(stdout);
}

class RelightBenchmark {
  public:
    explicit RelightBenchmark(const Options& options) : options_(options) {
        result_ = bake(Registry::load(), options.mesh, bake_options(options), execution_);
        solve_ = result_.options.solve;
        std::printf("%s: %zu sites, %zu surfels, %zu rays a site, %d channels, two threads\n\n", options.mesh.c_str(),
                    result_.sites->size(), system().transport().surfels, options.rays, result_.channels);
    }

    /// Lights that are known beforehand: each is solved for once, and any mixture of them is a product.
    void emission() const {
        const Values g = random_lights(8), one = g.leftCols(rho().cols());
        std::optional<LightResponses> responses;
        const Time formed = measure([&] { responses.emplace(system(), rho(), g, solve_, execution_); });
        const Values factors = Values::Constant(8, 1, 0.5);
        const std::vector<Time> times =
            measure_in_turns(options_.repeat, {[&] { (void)responses->mixed(factors, execution_); },
                                               [&] { (void)solve_for(system(), rho(), one, solve_, execution_); }});
        print_row("emission of 8 lights, by their responses", times[0]);
        print_row("emission of one light, by iteration", times[1]);
        print_row("once: the responses to 8 lights", formed);
    }

    /// Any light, by an operator of low rank.
    void low_rank() const {
        if (options_.rank == 0) {
            return;
        }
        const std::string name = "low-rank:bounces=1,rank=" + std::to_string(options_.rank);
        const Values one = random_lights(1);
        std::optional<RenderingOperator> T;
        const Time formed =
            measure([&] { T.emplace(result_.system, rho(), parse_operator(name), radius(), solve_, execution_); });
        const std::vector<Time> times = measure_in_turns(options_.repeat, {[&] { (void)T->apply(one, execution_); }});
        print_row(("T g, " + name).c_str(), times[0]);
        print_row(("once: T, " + name).c_str(), formed);
    }

    /// The ratio of processor times.
    void at_once() const {
        const Values g = random_lights(options_.lights);
        const Eigen::Index channels = rho().cols();
        const std::vector<Time> times = measure_in_turns(
            options_.repeat, {[&] { (void)solve_for(system(), rho(), g, solve_, execution_); },
                              [&] {
                                  for (Eigen::Index c = 0; c < g.cols(); c += channels) {
                                      (void)solve_for(system(), rho(), g.middleCols(c, channels), solve_, execution_);
                                  }
                              }});
        const std::string lights = std::to_string(options_.lights);
        print_row((lights + " lights at once").c_str(), times[0]);
        print_row((lights + " lights one after the other").c_str(), times[1]);
        std::printf("| at once, of one after the other | %.3f | %.3f |\n", times[0].wall / times[1].wall,
                    times[0].processor / times[1].processor);
    }

    void moved_sun() const {
        auto scene = std::make_shared<Scene>(*result_.scene);
        if (scene->suns.empty()) {
            return;
        }
        scene->suns.front().towards = (scene->suns.front().towards + Vec3(0.02, 0.03, 0.0)).normalized();
        LightingOptions live, by_operator;
        live.solve = by_operator.solve = solve_;
        by_operator.first_bounce = FirstBounce::operator_only;
        const std::vector<Time> times =
            measure_in_turns(options_.repeat, {[&] { (void)system().solve(scene, by_operator, execution_); },
                                               [&] { (void)system().solve(scene, live, execution_); }});
        print_row("a moved sun, first bounce by the operator", times[0]);
        print_row("a moved sun, first bounce live", times[1]);
    }

    /// In a hall of its own, 10 by 8 by 3 m, with as many sites and rays.
    void moved_crate() const {
        const Mesh walls = test::box(Vec3(10, 8, 3), 1, true),
                   crate = test::moved(test::box(0.4), 1.0, Vec3(4.0, 3.0, 0.5));
        Scene scene;
        scene.mesh = test::together(walls, crate);
        scene.materials.emplace_back().emission = Rgb::Ones();
        const Registry registry = Registry::load();
        const BakeResult hall = bake(registry, scene, "hall", bake_options(options_), execution_);
        const SystemParts& before = hall.system->parts();
        std::vector<char> marked(scene.mesh.triangles.size(), 0);
        std::fill(marked.begin() + static_cast<std::ptrdiff_t>(walls.triangles.size()), marked.end(), char{1});
        RigidMotion motion;
        motion.offset = Vec3(2.0, 1.0, 0.0);
        const Mesh mesh = moved_mesh(before.scene->mesh, marked, motion);
        std::vector<std::string> notes;
        const auto engine = built_over(mesh, registry.create<Visibility>(choose_visibility(registry, "auto", notes)));
        const Tracer tracer(mesh, *engine);
        const std::vector<SurfacePoint> points = moved_points(before.discretisation.points, mesh, marked);
        const Surfels surfels(mesh, before.discretisation.surfels->edge(), execution_);
        RecastCount count;
        const std::vector<Time> times = measure_in_turns(
            options_.repeat,
            {[&] {
                 count = {};
                 (void)recast(before.transport,
                              {hall.system->tracer(), before.discretisation.points, *before.discretisation.surfels},
                              {tracer, points, surfels}, marked, *before.directions, options_.rays, before.seed, count,
                              execution_);
             },
             [&] {
                 (void)gathered(tracer, points, surfels, *before.directions, options_.rays, before.seed, execution_);
             }});
        char rays[100];
        std::snprintf(rays, sizeof rays, "a moved crate: the %.1f %% of the rays that may meet it",
                      100.0 * static_cast<double>(count.anew) / static_cast<double>(count.anew + count.kept));
        print_row(rays, times[0]);
        print_row("the same: all rays", times[1]);
        std::printf("| those that may meet it, of all | %.3f | %.3f |\n", times[0].wall / times[1].wall,
                    times[0].processor / times[1].processor);
    }

  private:
    static BakeOptions bake_options(const Options& options) {
        BakeOptions of_bake;
        of_bake.sites = options.sites;
        of_bake.rays = options.rays;
        of_bake.every_surface = true;
        of_bake.error_points = 0;
        of_bake.output_spacing = 1e30;
        return of_bake;
    }

    const RadiositySystem& system() const { return *result_.system; }
    const Values& rho() const { return result_.solution.light.reflectance; }
    double radius() const { return result_.solution.spectral_radius; }

    /// The light of random patches of a hundredth of the surface, which follow each other in the order of the surfels.
    Values random_lights(std::size_t count) const {
        const auto surfels = static_cast<Eigen::Index>(system().transport().surfels), channels = rho().cols();
        Values b = Values::Zero(surfels, static_cast<Eigen::Index>(count) * channels), g;
        RandomStream stream(1, "lights");
        for (Eigen::Index l = 0; l < static_cast<Eigen::Index>(count); ++l) {
            const Eigen::Index patch = std::max<Eigen::Index>(surfels / 100, 1);
            const auto first = static_cast<Eigen::Index>(stream.below(static_cast<std::uint64_t>(surfels - patch + 1)));
            b.block(first, l * channels, patch, channels).setConstant(1.0 + stream.uniform());
        }
        system().transport().gather(b, {}, g, execution_);
        return g;
    }

    Options options_;
    Execution execution_{2};
    BakeResult result_;
    SolveOptions solve_;
};

} // namespace

int main(int argc, char** argv) {
    try {
        RelightBenchmark benchmark{Options(argc, argv)};
        std::printf("| what | wall, ms | processor, ms |\n|---|---|---|\n");
        benchmark.emission();
        benchmark.moved_sun();
        benchmark.at_once();
        benchmark.moved_crate();
        benchmark.low_rank();
        return 0;
    } catch (const Error& error) {
        std::fprintf(stderr, "error: %s\n", error.what());
        return static_cast<int>(error.code());
    } catch (const std::exception& error) {
        std::fprintf(stderr, "error: %s\n", error.what());
        return static_cast<int>(ExitCode::internal);
    }
}
