#include <difusa/output/error_chart.h>

#include <difusa/bake/error_target.h>
#include <difusa/core/error.h>
#include <difusa/io/chart.h>

#include <utility>

namespace difusa {

std::string error_chart_of(const BakeResult& result) {
    DIFUSA_REQUIRE(!result.attempts.empty() && result.options.target);
    const bool goals = result.attempts.front().goals.has_value();
    ChartSeries estimate{goals ? "field, estimate" : "estimate", {}, {}, 2.0, true, 0, true};
    ChartSeries end{goals ? "goals, half width of the 95 % interval" : "97.5 % end", {}, {}, 2.0, true, 0, false};
    ChartSeries target{"ordered", {}, {}, 1.5, false, 1, false};
    double seconds = 0.0;
    for (const Attempt& attempt : result.attempts) {
        seconds += attempt.seconds;
        estimate.x.push_back(seconds);
        estimate.y.push_back(100.0 * attempt.rms);
        end.x.push_back(seconds);
        end.y.push_back(100.0 * attempt.goals.value_or(attempt.high));
    }
    target.x = {0.5 * result.attempts.front().seconds, 2.0 * seconds};
    target.y.assign(2, 100.0 * result.options.target->relative);
    const Effort& last = result.attempts.back().effort;
    Chart chart;
    chart.title = "Error of " + std::to_string(result.attempts.size()) +
                  (result.attempts.size() == 1 ? " attempt" : " attempts") + ", the last with " +
                  std::to_string(last.sites) + " sites and " + std::to_string(last.rays) + " rays from each";
    chart.x_title = "seconds";
    chart.y_title = goals ? "relative error, %" : "rms error of the reflected light, %";
    chart.x_log = chart.y_log = true;
    chart.series = {std::move(end), std::move(estimate), std::move(target)};
    return svg_of(chart);
}

} // namespace difusa
