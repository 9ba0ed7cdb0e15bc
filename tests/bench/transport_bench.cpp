// How much does the transport phase of a bake cost beside its rays? For each visibility engine: rays a second of
// `gathered`, and of a bare loop that casts the very same rays with the same engine and does nothing with what they
// meet; their ratio; what a second thread gains; and the memory of the transport operator for more and more sites.
//
//     transport_bench [--mesh FILE | --triangles 240000] [--sites 10000] [--rays 256] [--repeat 5]
//                     [--visibility cgal,embree]
//
// Prints Markdown. All kinds of runs take turns, and medians are given, because other work may load the machine;
// ratios of work are from processor times, which other work disturbs less, the gain of a second thread from wall times.
#include "setting.h"

#include <difusa/core/parallel.h>
#include <difusa/discretisation/discretisation.h>
#include <difusa/rays/direction_pool.h>
#include <difusa/rays/directions.h>
#include <difusa/rays/tracer.h>
#include <difusa/rays/visibility.h>
#include <difusa/transport/gathered.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <functional>
#include <map>
#include <sstream>

namespace {

using namespace difusa;

std::size_t count_of(const std::string& option, const std::string& text) {
    std::size_t count = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
    if (error != std::errc() || end != text.data() + text.size() || count == 0) {
        throw UsageError(option + " " + text + ": must be a positive whole number");
    }
    return count;
}

struct Options {
    std::string mesh, visibility = "cgal,embree";
    std::size_t triangles = 240'000, sites = 10'000, rays = 256, repeat = 5;

    Options(int argc, char** argv) {
        const std::map<std::string, std::string*> words{{"--mesh", &mesh}, {"--visibility", &visibility}};
        const std::map<std::string, std::size_t*> counts{
            {"--triangles", &triangles}, {"--sites", &sites}, {"--rays", &rays}, {"--repeat", &repeat}};
        for (int i = 1; i < argc; i += 2) {
            const std::string option = argv[i];
            if (i + 1 == argc || (!words.contains(option) && !counts.contains(option))) {
                throw UsageError(option + ": options are --mesh FILE, --triangles N, --sites N, --rays N, --repeat N, "
                                          "--visibility NAME,NAME");
            }
            if (words.contains(option)) {
                *words.at(option) = argv[i + 1];
            } else {
                *counts.at(option) = count_of(option, argv[i + 1]);
            }
        }
    }
};

/// Wall time and processor time of all threads, in seconds.
struct Time {
    double wall = 0.0, processor = 0.0;
};

Time measure(const std::function<void()>& work) {
    const auto processor = [] {
        timespec time{};
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
        return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
    };
    const auto wall_before = std::chrono::steady_clock::now();
    const double before = processor();
    work();
    const double after = processor();
    return {std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_before).count(), after - before};
}

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

class Benchmark {
  public:
    explicit Benchmark(const Options& options)
        : options_(options), registry_(Registry::load()),
          scene_(bench::make_scene(registry_, options.mesh, options.triangles)),
          sites_(bench::make_sites(registry_, scene_, options.sites, {})),
          surfels_(scene_.mesh, Discretisation::surfel_edge(sites_.spacing), Execution{}),
          directions_(registry_.create<Directions>("low-discrepancy")) {
        const DirectionPool pool(*directions_, options.rays, bench::seed);
        rays_a_site_ = pool.count();
        rays_.resize(sites_.size() * rays_a_site_);
        for (std::size_t j = 0; j < sites_.size(); ++j) {
            pool.rays(sites_.points[j], j, std::span(rays_).subspan(j * rays_a_site_, rays_a_site_));
        }
        std::printf("%zu triangles, %zu sites, %zu surfels, %zu rays a site, %zu repetitions\n\n",
                    scene_.mesh.triangles.size(), sites_.size(), surfels_.size(), rays_a_site_, options.repeat);
    }

    void compare(const std::vector<std::string>& engines) {
        std::printf(
            "Processor time of a ray, in microseconds, and its ratio (aim: at most 1.25); wall time, and what the "
            "second thread gains (aim: at least 1.8).\n\n"
            "| visibility | threads | bare, us | gather, us | gather / bare | bare, Mrays/s | gather, Mrays/s | "
            "gather, s | gain, bare | gain, gather |\n"
            "|---|---|---|---|---|---|---|---|---|---|\n");
        for (const std::string& engine : engines) {
            compare(engine);
        }
    }

    void memory(const std::string& engine) const {
        std::printf("\n| sites | surfels | transport, MB | bytes a site | bytes a ray |\n|---|---|---|---|---|\n");
        const auto visibility = registry_.create<Visibility>(engine);
        visibility->build(scene_.mesh);
        for (const std::size_t part : {4, 2, 1}) {
            const SiteSet sites =
                bench::make_sites(registry_, scene_, std::max<std::size_t>(options_.sites / part, 1), {});
            const Surfels surfels(scene_.mesh, Discretisation::surfel_edge(sites.spacing), Execution{});
            const LightTransport transport = gathered({scene_.mesh, *visibility}, sites.points, surfels, *directions_,
                                                      options_.rays, bench::seed, Execution{2});
            const auto bytes = static_cast<double>(transport.bytes);
            std::printf("| %zu | %zu | %.1f | %.0f | %.2f |\n", sites.size(), surfels.size(), 1e-6 * bytes,
                        bytes / static_cast<double>(sites.size()), bytes / static_cast<double>(transport.rays));
        }
    }

  private:
    /// Casts all rays, a batch for each site as `gathered` does.
    void cast(const Visibility& visibility, const Execution& execution) const {
        std::vector<std::vector<Hit>> hits(execution.threads, std::vector<Hit>(rays_a_site_));
        parallel_for(sites_.size(), 16, execution, [&](std::size_t begin, std::size_t end, unsigned worker) {
            for (std::size_t j = begin; j < end; ++j) {
                visibility.first_hits(std::span(rays_).subspan(j * rays_a_site_, rays_a_site_), hits[worker]);
            }
        });
    }

    void compare(const std::string& engine) const {
        const auto visibility = registry_.create<Visibility>(engine);
        visibility->build(scene_.mesh);
        std::vector<Time> bare[2], whole[2]; // with one thread and with two
        for (std::size_t i = 0; i < options_.repeat + 1; ++i) {
            for (const unsigned threads : {1U, 2U}) {
                const Execution execution{threads};
                LightTransport transport;
                const Time cast_time = measure([&] { cast(*visibility, execution); });
                const Time gather_time = measure([&] {
                    transport = gathered({scene_.mesh, *visibility}, sites_.points, surfels_, *directions_,
                                         options_.rays, bench::seed, execution);
                });
                if (i > 0) { // the first round warms up
                    bare[threads - 1].push_back(cast_time);
                    whole[threads - 1].push_back(gather_time);
                }
            }
        }
        const auto over_repetitions = [&](const auto& quantity) {
            std::vector<double> values;
            for (std::size_t i = 0; i < options_.repeat; ++i) {
                values.push_back(quantity(i));
            }
            return median(std::move(values));
        };
        const double million_rays = 1e-6 * static_cast<double>(rays_.size());
        for (const std::size_t t : {0, 1}) {
            const double bare_wall = over_repetitions([&](std::size_t i) { return bare[t][i].wall; });
            const double whole_wall = over_repetitions([&](std::size_t i) { return whole[t][i].wall; });
            std::printf("| %s | %zu | %.3f | %.3f | %.3f | %.3f | %.3f | %.2f |", engine.c_str(), t + 1,
                        over_repetitions([&](std::size_t i) { return bare[t][i].processor; }) / million_rays,
                        over_repetitions([&](std::size_t i) { return whole[t][i].processor; }) / million_rays,
                        over_repetitions([&](std::size_t i) { return whole[t][i].processor / bare[t][i].processor; }),
                        million_rays / bare_wall, million_rays / whole_wall, whole_wall);
            if (t == 0) {
                std::printf(" | |\n");
            } else {
                std::printf(" %.2f | %.2f |\n",
                            over_repetitions([&](std::size_t i) { return bare[0][i].wall / bare[1][i].wall; }),
                            over_repetitions([&](std::size_t i) { return whole[0][i].wall / whole[1][i].wall; }));
            }
        }
        std::fflush(stdout);
    }

    Options options_;
    Registry registry_;
    Scene scene_;
    SiteSet sites_;
    Surfels surfels_;
    std::shared_ptr<Directions> directions_;
    std::size_t rays_a_site_ = 0;
    std::vector<Ray> rays_;
};

} // namespace

int main(int argc, char** argv) {
    try {
        const Options options(argc, argv);
        std::vector<std::string> engines;
        std::istringstream list(options.visibility);
        for (std::string engine; std::getline(list, engine, ',');) {
            engines.push_back(engine);
        }
        Benchmark benchmark(options);
        benchmark.compare(engines);
        benchmark.memory(engines.back());
        return 0;
    } catch (const Error& error) {
        std::fprintf(stderr, "error: %s\n", error.what());
        return static_cast<int>(error.code());
    } catch (const std::exception& error) {
        std::fprintf(stderr, "error: %s\n", error.what());
        return static_cast<int>(ExitCode::internal);
    }
}
