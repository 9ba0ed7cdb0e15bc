#include <difusa/study/study.h>

#include <difusa/bake/choices.h>
#include <difusa/core/error.h>
#include <difusa/core/text.h>
#include <difusa/io/chart.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>

namespace difusa {

namespace {

using Json = nlohmann::ordered_json;

/// Why a bake with these choices would be refused; empty if it would not.
std::string contradiction(const Registry& registry, const BakeOptions& options) {
    try {
        make_choices(registry, options);
        return "";
    } catch (const UsageError& error) {
        return error.what();
    }
}

/// The columns of the tables, by name, in order; unknown numbers are absent.
struct Column {
    const char* name;
    std::optional<double> (*value)(const Measurement&);
};

std::optional<double> known(const Measurement& m, double value) {
    return m.failed || !std::isfinite(value) ? std::nullopt : std::optional(value);
}

/// The bound over the true error: above 1 if it holds. Absent where there is no bound or no error to speak of.
std::optional<double> bound_over_error(const Measurement& m) {
    return m.total.l2.error > 0.0 ? known(m, m.bound / m.total.l2.error) : std::nullopt;
}

template <Norm ErrorNorms::*norm> std::optional<double> total(const Measurement& m) {
    return m.failed ? std::nullopt : (m.total.*norm).relative();
}
template <Norm ErrorNorms::*norm> std::optional<double> indirect(const Measurement& m) {
    return m.failed || m.indirect.area == 0.0 ? std::nullopt : (m.indirect.*norm).relative();
}

const std::vector<Column>& columns() {
    static const std::vector<Column> all{
        {"spacing", [](const Measurement& m) { return std::optional(m.options.spacing); }},
        {"rays", [](const Measurement& m) { return std::optional(static_cast<double>(m.options.rays)); }},
        {"final_gather",
         [](const Measurement& m) { return std::optional(static_cast<double>(m.options.final_gather)); }},
        {"sites", [](const Measurement& m) { return known(m, static_cast<double>(m.sites)); }},
        {"rays_cast", [](const Measurement& m) { return known(m, static_cast<double>(m.rays)); }},
        {"segments_cast", [](const Measurement& m) { return known(m, static_cast<double>(m.segments)); }},
        {"iterations", [](const Measurement& m) { return known(m, m.iterations); }},
        {"seconds", [](const Measurement& m) { return known(m, m.seconds); }},
        {"seconds_output", [](const Measurement& m) { return known(m, m.seconds_output); }},
        {"relative_l1", total<&ErrorNorms::l1>},
        {"relative_l2", total<&ErrorNorms::l2>},
        {"relative_linf", total<&ErrorNorms::linf>},
        {"relative_p95", total<&ErrorNorms::percentile95>},
        {"relative_p99", total<&ErrorNorms::percentile99>},
        {"relative_bias", total<&ErrorNorms::bias>},
        {"relative_energy_error", total<&ErrorNorms::integral>},
        {"indirect_relative_l1", indirect<&ErrorNorms::l1>},
        {"indirect_relative_l2", indirect<&ErrorNorms::l2>},
        {"indirect_relative_linf", indirect<&ErrorNorms::linf>},
        {"indirect_relative_p95", indirect<&ErrorNorms::percentile95>},
        {"indirect_relative_p99", indirect<&ErrorNorms::percentile99>},
        {"indirect_relative_bias", indirect<&ErrorNorms::bias>},
        {"l2_error_W_per_m2", [](const Measurement& m) { return known(m, m.total.l2.error); }},
        {"estimate_W_per_m2", [](const Measurement& m) { return known(m, m.estimate.rms); }},
        {"estimate_high_W_per_m2", [](const Measurement& m) { return known(m, m.estimate.high); }},
        {"bound_W_per_m2", [](const Measurement& m) { return known(m, m.bound); }},
        {"bound_over_error", bound_over_error},
    };
    return all;
}

std::string scientific(std::optional<double> value) {
    if (!value) {
        return "–";
    }
    char text[32];
    std::snprintf(text, sizeof text, "%.1e", *value);
    return text;
}

std::string chart(const std::vector<Measurement>& measurements, const std::string& case_name,
                  const std::string& x_title, double (*x)(const Measurement&)) {
    Chart chart;
    chart.title = case_name + ": error of the radiosity";
    chart.x_title = x_title;
    chart.y_title = "relative L2 error";
    chart.x_log = chart.y_log = true;
    std::vector<std::string> order;
    std::map<std::string, ChartSeries> lines;
    std::map<std::string, int> colours;
    const bool many_rays = std::any_of(measurements.begin(), measurements.end(), [&](const Measurement& m) {
        return m.options.rays != measurements.front().options.rays;
    });
    for (const Measurement& m : measurements) {
        if (m.case_name != case_name || m.failed) {
            continue;
        }
        const std::string method = method_of(m) + (many_rays ? ", " + std::to_string(m.options.rays) + " rays" : "");
        ChartSeries& line = lines[method];
        if (line.name.empty()) {
            order.push_back(method);
            line.name = method;
            line.markers = true;
            // A basis has one colour; the dash pattern shows how it is used.
            line.colour = colours.try_emplace(m.options.basis, static_cast<int>(colours.size())).first->second;
            line.dashed = method_of(m) != m.options.basis;
        }
        line.x.push_back(x(m));
        line.y.push_back(m.total.l2.relative().value_or(0.0));
    }
    for (const std::string& method : order) {
        chart.series.push_back(lines[method]);
    }
    return svg_of(chart);
}

} // namespace

std::string method_of(const Measurement& m) {
    std::string method = m.options.basis;
    method += m.options.projection.empty() || m.options.projection == "natural" ? "" : ", " + m.options.projection;
    method += m.options.transport == "gather" ? "" : ", " + m.options.transport;
    method += m.options.final_gather == 0 ? "" : ", final gather " + std::to_string(m.options.final_gather);
    return method;
}

std::vector<Measurement> run_study(const Registry& registry, const StudyPlan& plan, const Execution& execution,
                                   const std::function<void(const Measurement&)>& tell) {
    std::vector<Measurement> measurements;
    std::string contradicted;
    for (const std::string& name : plan.cases.empty() ? reference_case_names() : plan.cases) {
        const Judge judge(reference_case(name), plan.how, execution);
        const std::vector<double>& spacings = plan.spacings.empty() ? judge.reference.spacings : plan.spacings;
        for (const std::string& transport : plan.transports) {
            for (const std::string& basis : plan.bases) {
                for (const std::string& projection : plan.projections) {
                    for (const std::size_t final_gather : plan.final_gathers) {
                        for (const std::size_t rays : plan.rays) {
                            for (const double spacing : spacings) {
                                BakeOptions options = plan.common;
                                options.transport = transport;
                                options.basis = basis;
                                options.projection = projection;
                                options.final_gather = final_gather;
                                options.rays = rays;
                                options.spacing = spacing;
                                if (const std::string why = contradiction(registry, options); !why.empty()) {
                                    contradicted = why;
                                    continue;
                                }
                                measurements.push_back(measure(registry, judge, options, plan.how, execution));
                                tell(measurements.back());
                            }
                        }
                    }
                }
            }
        }
    }
    if (measurements.empty()) {
        throw UsageError("these choices cannot be combined: " + contradicted);
    }
    return measurements;
}

std::string csv_of(const std::vector<Measurement>& measurements) {
    std::string csv = "case,basis,projection,transport,visibility";
    for (const Column& column : columns()) {
        csv += std::string(",") + column.name;
    }
    csv += ",failure\n";
    for (const Measurement& m : measurements) {
        csv += csv_quoted(m.case_name) + "," + csv_quoted(m.options.basis) + "," + csv_quoted(m.options.projection) +
               "," + csv_quoted(m.options.transport) + "," + csv_quoted(m.options.visibility);
        for (const Column& column : columns()) {
            const std::optional<double> value = column.value(m);
            csv += "," + (value ? text_of(*value) : std::string());
        }
        csv += "," + (m.failed ? csv_quoted(m.failure) : std::string()) + "\n";
    }
    return csv;
}

std::string json_of(const std::vector<Measurement>& measurements) {
    Json study;
    study["schema"] = "difusa-accuracy-study";
    study["schema_version"] = 1;
    study["measurements"] = Json::array();
    for (const Measurement& m : measurements) {
        Json entry{{"case", m.case_name},
                   {"basis", m.options.basis},
                   {"projection", m.options.projection},
                   {"transport", m.options.transport},
                   {"visibility", m.options.visibility},
                   {"seed", m.options.seed}};
        for (const Column& column : columns()) {
            const std::optional<double> value = column.value(m);
            entry[column.name] = value ? Json(*value) : Json(nullptr);
        }
        entry["failure"] = m.failed ? Json(m.failure) : Json(nullptr);
        study["measurements"].push_back(std::move(entry));
    }
    return study.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string markdown_of(const std::vector<Measurement>& measurements, const std::string& case_name) {
    std::string table =
        "| method | spacing | rays | sites | seconds | L2 total | L2 indirect | largest | bound / error |\n"
        "|---|---|---|---|---|---|---|---|---|\n";
    for (const Measurement& m : measurements) {
        if (m.case_name != case_name) {
            continue;
        }
        table +=
            "| " + method_of(m) + " | " + text_of(m.options.spacing) + " | " + std::to_string(m.options.rays) + " | ";
        if (m.failed) {
            table += "– | – | " + m.failure + " | | | |\n";
            continue;
        }
        char seconds[32], ratio[32] = "–";
        std::snprintf(seconds, sizeof seconds, "%.2f", m.seconds + m.seconds_output);
        if (const std::optional<double> value = bound_over_error(m)) {
            std::snprintf(ratio, sizeof ratio, "%.1f", *value);
        }
        table += std::to_string(m.sites) + " | " + seconds + " | " + scientific(total<&ErrorNorms::l2>(m)) + " | " +
                 scientific(indirect<&ErrorNorms::l2>(m)) + " | " + scientific(total<&ErrorNorms::linf>(m)) + " | " +
                 ratio + " |\n";
    }
    return table;
}

std::string error_against_time(const std::vector<Measurement>& measurements, const std::string& case_name) {
    return chart(measurements, case_name, "seconds", [](const Measurement& m) { return m.seconds + m.seconds_output; });
}

std::string error_against_sites(const std::vector<Measurement>& measurements, const std::string& case_name) {
    return chart(measurements, case_name, "sites", [](const Measurement& m) { return static_cast<double>(m.sites); });
}

} // namespace difusa
