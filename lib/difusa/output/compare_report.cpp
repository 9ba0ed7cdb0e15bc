#include <difusa/study/compare.h>

#include <difusa/version.h>

#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

namespace difusa {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<std::pair<const char*, Norm ErrorNorms::*>, 7> norm_names{
    {{"l1", &ErrorNorms::l1},
     {"l2", &ErrorNorms::l2},
     {"linf", &ErrorNorms::linf},
     {"percentile95", &ErrorNorms::percentile95},
     {"percentile99", &ErrorNorms::percentile99},
     {"bias", &ErrorNorms::bias},
     {"integral", &ErrorNorms::integral}}};
constexpr std::array<const char*, 7> norm_words{
    "L1, mean |error|",          "L2, root mean square", "L-infinity, largest", "95 % of the area is below",
    "99 % of the area is below", "bias, mean error",     "integral, energy"};

Json norms_of(const ErrorNorms& norms) {
    Json json;
    for (const auto& [name, member] : norm_names) {
        const Norm& norm = norms.*member;
        json[name] = {{"error", norm.error}, {"reference", norm.reference}};
        json[name]["relative"] = norm.relative() ? Json(*norm.relative()) : Json(nullptr);
    }
    return json;
}

std::string text(const char* format, double value) {
    std::array<char, 64> buffer{};
    std::snprintf(buffer.data(), buffer.size(), format, value);
    return buffer.data();
}

std::string right(const std::string& word, std::size_t width) {
    return std::string(word.size() < width ? width - word.size() : 1, ' ') + word;
}

std::string relative(const Norm& norm) {
    return norm.relative() ? text("%.3g %%", 100.0 * *norm.relative()) : "-";
}

} // namespace

std::string table_of(const Comparison& comparison) {
    const Matching& matching = comparison.matching;
    std::string table = matching.same_mesh
                            ? "same mesh, compared vertex by vertex"
                            : "different meshes, the reference interpolated at its nearest point; " +
                                  text("%.4g %%", 100.0 * matching.matched_area / matching.area) +
                                  " of the area matched, within " + text("%.3g", matching.largest_distance);
    table += "; area " + text("%.6g", matching.area) + "\n";
    for (const ComparedQuantity& quantity : comparison.quantities) {
        const FieldNorms& norms = quantity.norms;
        const std::string title = quantity.name + (quantity.unit.empty() ? "" : ", " + quantity.unit) +
                                  (norms.weighted             ? " (weighted)"
                                   : norms.channel.size() > 1 ? " (all channels)"
                                                              : "");
        table += "\n" + title + right("error", title.size() < 38 ? 50 - title.size() : 12) + right("reference", 12) +
                 right("relative", 12);
        if (norms.channel.size() > 1) {
            for (const std::string& component : quantity.components) {
                table += right(component, 10);
            }
            table += norms.weighted ? right("all", 10) : "";
        }
        table += "\n";
        const ErrorNorms& main = norms.weighted ? *norms.weighted : norms.all;
        for (std::size_t i = 0; i < norm_names.size(); ++i) {
            const auto member = norm_names[i].second;
            const std::string word = std::string("  ") + norm_words[i];
            table += word + right(text("%.4g", (main.*member).error), 50 - word.size()) +
                     right(text("%.4g", (main.*member).reference), 12) + right(relative(main.*member), 12);
            if (norms.channel.size() > 1) {
                for (const ErrorNorms& channel : norms.channel) {
                    table += right(relative(channel.*member), 10);
                }
                table += norms.weighted ? right(relative(norms.all.*member), 10) : "";
            }
            table += "\n";
        }
    }
    return table;
}

std::string report_of(const Comparison& comparison, const std::string& result_name, const std::string& reference_name) {
    Json report;
    report["schema"] = "difusa-comparison";
    report["schema_version"] = 3;
    report["difusa_version"] = version();
    report["result"] = result_name;
    report["reference"] = reference_name;
    const Matching& matching = comparison.matching;
    report["matching"] = {{"same_mesh", matching.same_mesh},
                          {"area", matching.area},
                          {"reference_area", matching.reference_area},
                          {"matched_area", matching.matched_area},
                          {"emitting_area", matching.emitting_area},
                          {"too_far_area", matching.too_far_area},
                          {"turned_away_area", matching.turned_away_area},
                          {"max_distance", matching.max_distance},
                          {"largest_distance", matching.largest_distance},
                          {"vertices", matching.matched.size()},
                          {"unmatched_vertices", matching.unmatched_vertices}};
    report["notes"] = comparison.notes;
    report["quantities"] = Json::array();
    for (const ComparedQuantity& quantity : comparison.quantities) {
        Json json{{"name", quantity.name}, {"unit", quantity.unit}};
        json["all"] = norms_of(quantity.norms.all);
        if (quantity.norms.weighted) {
            json["weighted"] = norms_of(*quantity.norms.weighted);
        }
        json["channels"] = Json::array();
        for (std::size_t c = 0; c < quantity.norms.channel.size(); ++c) {
            Json channel{{"name", quantity.components.empty() ? std::string() : quantity.components[c]}};
            channel.update(norms_of(quantity.norms.channel[c]));
            json["channels"].push_back(channel);
        }
        report["quantities"].push_back(json);
    }
    return report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

} // namespace difusa
