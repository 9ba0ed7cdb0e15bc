#include <difusa/bake/trial.h>

#include <difusa/bake/cost.h>
#include <difusa/bake/steps.h>
#include <difusa/core/error.h>
#include <difusa/core/memory.h>
#include <difusa/transport/analytic_transport.h>
#include <difusa/transport/gathered.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace difusa {

namespace {

constexpr double share_of_sites = 0.1, fewest_placed = 300.0, most_placed = 2000.0;
constexpr double most_trial_rays = 1 << 20;
constexpr std::size_t fewest_rays = 64, most_gathered = 64;
constexpr std::string_view exact_factors = "exact form factors"; ///< the phase

/// The trial, and by what factors the bake is larger.
class Trial {
  public:
    BakeResult result;

    Trial(const BakeResult& bake, bool pairwise) : result(bake), pairwise_(pairwise) {
        const auto n = static_cast<double>(bake.estimate.sites);
        const double few = std::min(n, std::clamp(share_of_sites * n, fewest_placed, most_placed));
        BakeOptions& options = result.options;
        options.sites = 0;
        options.error_rounds = 0; // whether there are more of them, so few sites do not tell
        options.spacing *= std::sqrt(n / few);
        options.output_spacing *= std::sqrt(n / few);
        options.rays = std::min(options.rays, std::max(fewest_rays, static_cast<std::size_t>(most_trial_rays / few)));
        options.final_gather = std::min(options.final_gather, most_gathered);
        options.keep_iterates = false;
        result.listed.clear(); // found again
        result.listed_distance.clear();
        result.listed_number.clear();
        result.sensors.clear();
    }

    /// Once the trial is done. `journal`: its own. `exact_factors_growth`: of the phase, which is timed by itself.
    void compare(const BakeResult& bake, const Journal& journal, double exact_factors_growth) {
        const auto placed = static_cast<double>(result.sites->size()), n = static_cast<double>(bake.estimate.sites);
        const auto triangles = static_cast<double>(result.scene->mesh.triangles.size());
        sites_ = n / placed;
        rays_ = ratio(bake.options.rays, result.options.rays);
        gathered_ = ratio(bake.options.final_gather, result.options.final_gather);
        bound_ = (n + triangles) / (placed + triangles);
        // The expected numbers leave out what each of many small parts has at least.
        const auto made = static_cast<double>(result.system->discretisation().surfels->size());
        const double few = std::max(expected_surfels(result), made), many = std::max(few, expected_surfels(bake));
        surfels_ = (many + triangles) / (few + triangles); // each triangle is gone through
        error_points_ = ratio(error_points(bake.options, bake.estimate.sites), result.options.error_points.value_or(0));
        // Refining adds vertices to those of the mesh in proportion to the sites.
        const auto vertices = static_cast<double>(result.mesh.vertices.size());
        const double own = std::min(vertices, static_cast<double>(result.scene->mesh.points.size()));
        vertices_ = vertices > 0.0 ? (own + sites_ * (vertices - own)) / vertices : 1.0;
        exact_ = exact_factors_growth;
        pilots_ = growth_of_pilots(journal);
    }

    double growth(std::string_view phase) const {
        if (phase == exact_factors) {
            return exact_;
        }
        if (phase == "transport") {
            return pairwise_ ? sites_ * sites_ : sites_ * rays_;
        }
        if (phase == "direct light") {
            return sites_ * rays_;
        }
        if (phase == "pilot bake") {
            return pilots_;
        }
        if (phase == "light surface" || phase == "divide surface" || phase == "set up projection") {
            return surfels_;
        }
        if (phase == "set up basis" || phase == "place sites") {
            return bound_;
        }
        if (phase == "estimate error") {
            return error_points_ * rays_;
        }
        if (phase == "estimate goals") {
            return rays_; // at as many points
        }
        if (phase == "refine output" || phase == "evaluate") {
            return vertices_ * (phase == "evaluate" ? gathered_ : 1.0);
        }
        return sites_;
    }

  private:
    /// As the trial itself, whose phases pilots have, on fewer sites.
    double growth_of_pilots(const Journal& journal) const {
        constexpr std::array<std::string_view, 8> phases{
            "divide surface", "set up projection", "transport",         exact_factors,
            "light surface",  "direct light",      "check convergence", "solve"};
        double trial = 0.0, whole = 0.0;
        for (const auto& [name, seconds] : journal.seconds()) {
            if (std::find(phases.begin(), phases.end(), name) != phases.end()) {
                trial += seconds;
                whole += seconds * growth(name);
            }
        }
        return trial > 0.0 ? whole / trial : 1.0;
    }

    static double ratio(std::size_t whole, std::size_t part) {
        return part > 0 ? static_cast<double>(whole) / static_cast<double>(part) : 1.0;
    }

    bool pairwise_;
    double sites_ = 1.0, rays_ = 1.0, gathered_ = 1.0, bound_ = 1.0, surfels_ = 1.0, error_points_ = 1.0,
           vertices_ = 1.0, exact_ = 1.0, pilots_ = 1.0;
};

/// Seconds that exact form factors take in the bake. Whether they pay depends on the size of the surfels and the number
/// of rays: it is tried out with those of the bake, at few points and at more of them.
double time_of_exact_factors(const BakeResult& bake, const BakeResult& trial, const Choices& choices,
                             const Execution& execution) {
    Execution one = execution.with(execution.progress, nullptr);
    one.threads = 1; // few points do not keep many threads busy
    constexpr std::array<std::size_t, 2> counts{96, 288};
    const RadiositySystem& system = *trial.system;
    const std::vector<SurfacePoint>& all = system.discretisation().points;
    const Mesh& mesh = trial.scene->mesh;
    const Surfels surfels(mesh, Discretisation::surfel_edge(bake.options.spacing), one);
    std::array<double, 2> seconds{};
    for (std::size_t k = 0; k < counts.size(); ++k) {
        std::vector<SurfacePoint> points;
        for (std::size_t i = 0; i < counts[k]; ++i) {
            points.push_back(all[i * all.size() / counts[k]]);
        }
        LightTransport by_rays = gathered(system.tracer(), points, surfels, *system.parts().directions,
                                          bake.options.rays, bake.options.seed, one);
        const std::shared_ptr<const LinearOperator> before = by_rays.W;
        const auto began = std::chrono::steady_clock::now();
        const LightTransport refined =
            with_analytic_factors(std::move(by_rays), mesh, points, surfels, choices.analytic, one);
        seconds[k] = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
        if (refined.W == before) {
            return seconds[k]; // some of the points show that they do not pay
        }
    }
    const double each = (seconds[1] - seconds[0]) / static_cast<double>(counts[1] - counts[0]);
    const double points = static_cast<double>(bake.estimate.sites) * static_cast<double>(all.size()) /
                          static_cast<double>(trial.sites->size());
    const double further = std::max(0.0, each * (points - static_cast<double>(counts[0])));
    return seconds[0] + further / static_cast<double>(execution.threads);
}

/// Adds up what has the same name, in the order of the first of each.
void add(std::vector<std::pair<std::string, double>>& phases, const std::string& name, double seconds) {
    const auto found =
        std::find_if(phases.begin(), phases.end(), [&](const auto& phase) { return phase.first == name; });
    if (found == phases.end()) {
        phases.emplace_back(name, seconds);
    } else {
        found->second += seconds;
    }
}

} // namespace

void predict_time(BakeResult& result, const Registry& registry, const Choices& choices, const SolveSteps& solve,
                  const Execution& execution) {
    execution.phase("trial bake");
    // What was done already takes as long in the bake.
    std::vector<std::pair<std::string, double>> phases;
    if (execution.journal != nullptr) {
        for (const auto& [name, seconds] : execution.journal->seconds()) {
            // A bake chooses the spacing where it places sites.
            add(phases, name == "predict sites" ? "place sites" : name, seconds);
        }
    }
    Trial trial(result, choices.pairwise);
    SubordinateProgress unreported(execution.progress);
    Journal journal;
    const Execution own = execution.with(&unreported, &journal);
    double exact_factors_growth = 1.0;
    const auto bytes = [](const BakeEstimate& estimate) { return estimate.transport_bytes + estimate.other_bytes; };
    try {
        Choices fresh = make_choices(registry, trial.result.options); // a basis is bound to its sites
        fresh.engine = choices.engine;
        solve(trial.result, fresh, own);
        evaluate_solution(trial.result, own);
        journal.end();
        // Meshes and trees are those of the bake.
        result.estimate.peak_bytes =
            static_cast<double>(peak_memory()) + std::max(0.0, bytes(result.estimate) - bytes(trial.result.estimate));
        const auto& timed = journal.seconds();
        const auto exact =
            std::find_if(timed.begin(), timed.end(), [](const auto& phase) { return phase.first == exact_factors; });
        if (exact != timed.end() && exact->second > 0.0) {
            exact_factors_growth = time_of_exact_factors(result, trial.result, choices, own) / exact->second;
        }
    } catch (const Interrupted&) {
        throw;
    } catch (const Error& error) {
        execution.note(std::string("the time cannot be predicted, because a bake with fewer sites fails: ") +
                       error.what());
        result.estimate.peak_bytes = static_cast<double>(peak_memory()) + bytes(result.estimate);
        return;
    }
    trial.compare(result, journal, exact_factors_growth);
    for (const auto& [name, seconds] : journal.seconds()) {
        if (name != "place sites" || !result.sites) {
            add(phases, name, seconds * trial.growth(name));
        }
    }
    result.estimate.phases = std::move(phases);
}

} // namespace difusa
