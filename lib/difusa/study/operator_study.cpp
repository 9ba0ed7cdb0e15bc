#include <difusa/study/operator_study.h>

#include <difusa/core/text.h>
#include <difusa/radiosity/reflected_transport.h>
#include <difusa/radiosity/response.h>

#include <algorithm>
#include <cmath>
#include <ctime>

namespace difusa {

namespace {

constexpr double tight = 1e-11;  ///< tolerance of the solution that errors are measured against
constexpr double to_form = 1e-8; ///< and of those that operators are formed with

/// Processor time of all threads since `begin`, in seconds.
double processor_seconds_since(std::clock_t begin) {
    return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

double root_of_squares(const std::vector<double>& values, std::size_t first, std::size_t count) {
    double sum = 0.0;
    for (std::size_t i = first; i < first + count; ++i) {
        sum += values[i] * values[i];
    }
    return std::sqrt(sum);
}

} // namespace

std::vector<OperatorTrial> try_operators(const BakeResult& result, std::span<const OperatorChoice> choices,
                                         const Execution& execution,
                                         const std::function<void(const OperatorTrial&)>& tell) {
    const RadiositySystem& system = *result.system;
    const Solution& solution = result.solution;
    const Values& rho = solution.light.reflectance;
    const ReflectedTransport T(system.discretisation(), system.transport(), rho);
    execution.phase("iteration");
    Values reflected;
    T.apply(solution.h, reflected, execution);
    const Values g = solution.h - reflected;
    SolveOptions solve = result.options.solve;
    solve.watch = {};
    const std::clock_t begin = std::clock();
    (void)solve_for(system, rho, g, solve, execution);
    const double iteration = processor_seconds_since(begin);
    solve.tolerance = std::min(solve.tolerance, tight);
    const Values h = solve_for(system, rho, g, solve, execution);
    solve.tolerance = std::min(result.options.solve.tolerance, to_form);
    const AreaNorms norms(system.discretisation());
    const std::vector<double> whole = norms.of_points(h);
    const auto channels = static_cast<std::size_t>(rho.cols());
    const std::vector<std::string>& lights = solution.field->sets().names;
    DIFUSA_REQUIRE(lights.size() * channels == static_cast<std::size_t>(h.cols()));
    if (h.isZero(0.0)) {
        throw UsageError(result.file + ": nothing is lit: there is no light to compare operators with");
    }
    std::vector<OperatorTrial> trials;
    for (const OperatorChoice& choice : choices) {
        execution.phase("operator");
        const std::clock_t before = std::clock();
        const RenderingOperator R(result.system, rho, choice, solution.spectral_radius, solve, execution);
        const std::clock_t made = std::clock();
        (void)R.apply(g, execution);
        const std::clock_t done = std::clock();
        std::vector<double> stated;
        const std::vector<double> error = norms.of_points(R.apply(g, stated, execution) - h);
        for (std::size_t l = 0; l < lights.size(); ++l) {
            const double rms = root_of_squares(whole, l * channels, channels);
            if (rms == 0.0) {
                continue;
            }
            OperatorTrial trial;
            trial.choice = choice.text;
            trial.light = lights[l];
            trial.points = system.transport().points();
            trial.stated = root_of_squares(stated, l * channels, channels) / rms;
            trial.measured = root_of_squares(error, l * channels, channels) / rms;
            trial.prepare_seconds = static_cast<double>(made - before) / CLOCKS_PER_SEC;
            trial.seconds = static_cast<double>(done - made) / CLOCKS_PER_SEC;
            trial.iteration_seconds = iteration;
            trial.bytes = R.bytes();
            trials.push_back(trial);
            tell(trial);
        }
    }
    return trials;
}

std::string operator_csv(std::span<const OperatorTrial> trials) {
    std::string table = "operator,light,points,stated_error,error,prepare_seconds,seconds,iteration_seconds,bytes\n";
    for (const OperatorTrial& trial : trials) {
        table += csv_quoted(trial.choice) + "," + csv_quoted(trial.light) + "," + std::to_string(trial.points);
        for (const double each :
             {trial.stated, trial.measured, trial.prepare_seconds, trial.seconds, trial.iteration_seconds}) {
            table += "," + exact_text(each);
        }
        table += "," + std::to_string(trial.bytes) + "\n";
    }
    return table;
}

} // namespace difusa
