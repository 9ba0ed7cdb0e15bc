#include <difusa/study/solver_study.h>

#include <difusa/core/error.h>
#include <difusa/core/text.h>
#include <difusa/io/chart.h>
#include <difusa/radiosity/reflected_transport.h>
#include <difusa/scene/sky_parts.h>

#include <chrono>
#include <cstdio>
#include <memory>

namespace difusa {

namespace {

using SolverClock = std::chrono::steady_clock;

double seconds_between(SolverClock::time_point begin, SolverClock::time_point end) {
    return std::chrono::duration<double>(end - begin).count();
}

/// A surface of one grey reflectance, with its light as one channel.
class GreySystem {
  public:
    GreySystem(const BakeResult& result, double albedo, const Solver& sure, const Execution& execution)
        : rho_(Values::Constant(static_cast<Eigen::Index>(result.system->transport().surfels), 1, albedo)),
          T_(result.system->discretisation(), result.system->transport(), rho_), problem_{&T_, {}} {
        const SurfelLight& light = result.solution.light;
        const Values b = light.emission.rowwise().mean() + albedo * light.direct.rowwise().mean();
        const Values sky =
            result.scene->has_sky() ? Values(sky_radiosity(*result.scene, 3).rowwise().mean()) : Values();
        result.system->transport().gather(b, sky, problem_.g, execution);
        SolveOptions options;
        options.tolerance = 1e-12;
        const SolveSummary summary = sure.solve(problem_, options, execution);
        if (!summary.converged()) {
            throw NotConverged("albedo " + text_of(albedo) + ": the solver krylov " + summary.sentence() +
                               "; use --basis normalized-radial, whose bounces die out");
        }
        solution_ = summary.h;
    }
    GreySystem(const GreySystem&) = delete;
    GreySystem& operator=(const GreySystem&) = delete;

    const SolveProblem& problem() const { return problem_; }
    const Values& solution() const { return solution_; }

  private:
    Values rho_;
    ReflectedTransport T_;
    SolveProblem problem_;
    Values solution_;
};

SolverTrial try_solver(const Solver& solver, const GreySystem& system, double tolerance, const Execution& execution) {
    const SolveProblem& problem = system.problem();
    SolverTrial trial;
    trial.tolerance = tolerance;
    trial.points = problem.T->rows();
    trial.product = static_cast<double>(problem.T->entry_count());
    SolveOptions options;
    options.tolerance = tolerance;
    options.max_iterations = 100'000;
    const SolverClock::time_point begin = SolverClock::now();
    double watching = 0.0;
    options.watch = [&](const Iterate& iterate) {
        const SolverClock::time_point now = SolverClock::now();
        Values residual;
        SolverStep step;
        step.iterations = static_cast<double>(iterate.relaxations) / static_cast<double>(trial.points);
        step.entries = static_cast<double>(iterate.entries);
        step.seconds = seconds_between(begin, now) - watching;
        step.residual = relative_residual(problem, iterate.h, residual, execution).front();
        step.error = (iterate.h - system.solution()).norm() / system.solution().norm();
        trial.steps.push_back(step);
        watching += seconds_between(now, SolverClock::now());
    };
    const SolveSummary summary = solver.solve(problem, options, execution);
    trial.seconds = seconds_between(begin, SolverClock::now()) - watching;
    trial.reason = summary.reason;
    trial.sentence = summary.sentence();
    trial.iterations = summary.iterations;
    trial.entries = static_cast<double>(summary.entries_touched);
    return trial;
}

} // namespace

std::vector<SolverTrial> try_solvers(const Registry& registry, const std::filesystem::path& file,
                                     const SolverPlan& plan, const Execution& execution,
                                     const std::function<void(const SolverTrial&)>& tell) {
    for (const double albedo : plan.albedos) {
        if (!(albedo > 0.0 && albedo < 1.0)) {
            throw UsageError("--albedo " + text_of(albedo) + ": must be above 0 and below 1");
        }
    }
    std::vector<std::shared_ptr<Solver>> solvers;
    BakeOptions options = plan.bake;
    options.output_spacing = 1e30;
    options.error_points = 0;
    for (const std::string& name : plan.solvers) {
        solvers.push_back(registry.create<Solver>(name));
        options.solver = solvers.back()->needs_factors() ? name : options.solver; // so that choices are checked for it
    }
    const BakeResult result = bake(registry, file, options, execution);
    const std::shared_ptr<Solver> sure = registry.create<Solver>("krylov");
    std::vector<SolverTrial> trials;
    for (const double albedo : plan.albedos) {
        const GreySystem system(result, albedo, *sure, execution);
        for (const double tolerance : plan.tolerances) {
            for (std::size_t s = 0; s < solvers.size(); ++s) {
                execution.check();
                trials.push_back(try_solver(*solvers[s], system, tolerance, execution));
                trials.back().scene = file.stem().string();
                trials.back().solver = plan.solvers[s];
                trials.back().albedo = albedo;
                tell(trials.back());
            }
        }
    }
    return trials;
}

std::string solver_header() {
    return "| scene | albedo | residual | solver | iterations to 5 % | iterations | products | seconds |\n"
           "|---|---|---|---|---|---|---|---|\n";
}

std::string solver_row(const SolverTrial& trial) {
    char numbers[96];
    std::snprintf(numbers, sizeof numbers, "%d | %.1f | %.3f", trial.iterations, trial.entries / trial.product,
                  trial.seconds);
    const bool converged = trial.reason == SolveSummary::Reason::converged;
    const SolverStep* const close = trial.close_to(0.05);
    char soon[32] = "–";
    if (close != nullptr) {
        std::snprintf(soon, sizeof soon, "%.3g", close->iterations);
    }
    return "| " + trial.scene + " | " + text_of(trial.albedo) + " | " + text_of(trial.tolerance) + " | " +
           trial.solver + " | " + soon + " | " + (converged ? std::string(numbers) : trial.sentence + " | |") + " |\n";
}

std::string solver_csv_header() {
    return "scene,albedo,tolerance,solver,points,entries_of_product,iterations,entries,seconds,residual,error\n";
}

std::string solver_csv_rows(const SolverTrial& trial) {
    std::string rows;
    for (const SolverStep& step : trial.steps) {
        rows += csv_quoted(trial.scene) + "," + text_of(trial.albedo) + "," + text_of(trial.tolerance) + "," +
                csv_quoted(trial.solver) + "," + std::to_string(trial.points) + "," + text_of(trial.product) + "," +
                text_of(step.iterations) + "," + text_of(step.entries) + "," + text_of(step.seconds) + "," +
                text_of(step.residual) + "," + text_of(step.error) + "\n";
    }
    return rows;
}

const SolverStep* SolverTrial::close_to(double error) const {
    const SolverStep* close = nullptr;
    for (auto step = steps.rbegin(); step != steps.rend() && step->error <= error; ++step) {
        close = &*step;
    }
    return close;
}

namespace {

std::string solver_chart(const std::vector<SolverTrial>& trials, SolverAxis axis, const char* y_title,
                         double SolverStep::*y) {
    Chart chart;
    if (!trials.empty()) {
        chart.title = trials.front().scene + ", albedo " + text_of(trials.front().albedo);
    }
    chart.x_title = axis == SolverAxis::iterations ? "iterations (relaxations per unknown)"
                    : axis == SolverAxis::entries  ? "matrix entries touched, in products with T"
                                                   : "seconds";
    chart.y_title = y_title;
    chart.x_log = chart.y_log = true;
    for (const SolverTrial& trial : trials) {
        ChartSeries line;
        line.name = trial.solver;
        line.colour = static_cast<int>(chart.series.size());
        line.dashed = chart.series.size() >= chart_colours; // the colours begin again
        for (const SolverStep& step : trial.steps) {
            line.x.push_back(axis == SolverAxis::iterations ? step.iterations
                             : axis == SolverAxis::entries  ? step.entries / trial.product
                                                            : step.seconds);
            line.y.push_back(step.*y);
        }
        chart.series.push_back(std::move(line));
    }
    return svg_of(chart);
}

} // namespace

std::string residual_chart(const std::vector<SolverTrial>& trials, SolverAxis axis) {
    return solver_chart(trials, axis, "largest residual, relative", &SolverStep::residual);
}

std::string error_chart(const std::vector<SolverTrial>& trials, SolverAxis axis) {
    return solver_chart(trials, axis, "rms error of what is shown, relative", &SolverStep::error);
}

} // namespace difusa
