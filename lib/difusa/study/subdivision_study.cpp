#include <difusa/study/subdivision_study.h>

#include <difusa/core/text.h>
#include <difusa/io/chart.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

namespace difusa {

namespace {

constexpr const char* even_mesh = "even mesh";

struct Method {
    const char *name, *projection;
    bool adaptive;
    std::vector<std::size_t> multiples;
};

/// The elements of an even mesh at this error, if it is between those of two of them.
std::optional<double> even_elements(const std::vector<SubdivisionTrial>& trials, double error) {
    std::optional<double> found;
    for (std::size_t i = 0; i + 1 < trials.size(); ++i) {
        const EstimateTrial &coarse = trials[i].trial, &fine = trials[i + 1].trial;
        const double above = coarse.relative_error(), below = fine.relative_error();
        if (trials[i + 1].method != even_mesh || !(above >= error && error >= below && above > below && below > 0.0)) {
            continue;
        }
        const double along = std::log(above / error) / std::log(above / below);
        const auto n = static_cast<double>(coarse.sites), m = static_cast<double>(fine.sites);
        found = n * std::pow(m / n, along);
    }
    return found;
}

} // namespace

std::vector<SubdivisionTrial> compare_subdivision(const Registry& registry, const KnownLight& light,
                                                  const BakeOptions& common, std::size_t elements,
                                                  const Execution& execution,
                                                  const std::function<void(const SubdivisionTrial&)>& tell) {
    const std::array<Method, 3> methods{{{even_mesh, "", false, {1, 2, 4, 8, 16}},
                                         {"divided patches", "substructured", true, {1, 2, 4, 8}},
                                         {"divided, each part for itself", "natural", true, {4, 8}}}};
    std::vector<SubdivisionTrial> trials;
    for (const Method& method : methods) {
        for (const std::size_t multiple : method.multiples) {
            BakeOptions own = common;
            own.basis = "patch-constant";
            own.sampler.clear();
            own.directions = "hemicube";
            own.direct = "interpolated";
            own.projection = method.projection;
            own.adaptive = method.adaptive;
            own.spacing = 0.0;
            own.sites = multiple * elements;
            const std::vector<EstimateTrial> one = try_estimate(registry, light, own, 1, execution, [](const auto&) {});
            SubdivisionTrial trial{light.name, method.name, one.front(), {}};
            if (method.adaptive) {
                trial.even = even_elements(trials, trial.trial.relative_error());
            }
            trials.push_back(std::move(trial));
            tell(trials.back());
        }
    }
    return trials;
}

std::string subdivision_header() {
    return "| scene | method | elements | unknowns | rays | processor, s | error | even elements at this error |\n"
           "|---|---|---|---|---|---|---|---|\n";
}

std::string subdivision_row(const SubdivisionTrial& t) {
    std::array<char, 128> numbers{};
    std::snprintf(numbers.data(), numbers.size(), "%zu | %zu | %.2f M | %.2f | %.2f %%", t.trial.sites,
                  t.trial.unknowns, 1e-6 * static_cast<double>(t.trial.rays), t.trial.field_seconds(),
                  100.0 * t.trial.relative_error());
    return "| " + t.scene + " | " + t.method + " | " + numbers.data() + " | " +
           (t.even ? std::to_string(std::lround(*t.even)) : "") + " |\n";
}

std::string subdivision_csv_header() {
    return "scene,method,elements,unknowns,rays,processor_seconds,error_W_per_m2,reflected_W_per_m2,relative_error,"
           "even_elements\n";
}

std::string subdivision_csv_row(const SubdivisionTrial& t) {
    return csv_quoted(t.scene) + "," + csv_quoted(t.method) + "," + std::to_string(t.trial.sites) + "," +
           std::to_string(t.trial.unknowns) + "," + std::to_string(t.trial.rays) + "," +
           text_of(t.trial.field_seconds()) + "," + text_of(t.trial.total) + "," + text_of(t.trial.reflected) + "," +
           text_of(t.trial.relative_error()) + "," + (t.even ? text_of(*t.even) : "") + "\n";
}

std::string subdivision_chart(const std::vector<SubdivisionTrial>& trials) {
    Chart chart;
    chart.title = trials.empty() ? "" : trials.front().scene + ": patches even and divided";
    chart.x_title = "elements";
    chart.y_title = "rms error relative to the reflected light";
    chart.x_log = chart.y_log = true;
    for (const SubdivisionTrial& t : trials) {
        chart.add(t.method, static_cast<double>(t.trial.sites), t.trial.relative_error());
    }
    return svg_of(chart);
}

} // namespace difusa
