#include <difusa/study/validation.h>

#include <difusa/core/error.h>
#include <difusa/core/text.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <utility>

namespace difusa {

namespace {

constexpr double ahead_of_the_surface = 1e-3; ///< m, of sensors

bool starts_with_one_of(const std::string& name, const std::vector<std::string>& starts) {
    return std::any_of(starts.begin(), starts.end(), [&](const std::string& start) { return name.starts_with(start); });
}

/// "1.2 %", or "0.004 %": two digits.
std::string share_in_percent(double share) {
    char text[32];
    std::snprintf(text, sizeof text, "%.2g %%", 100.0 * share);
    return text;
}

struct Largest {
    double deviation = 0.0;
    std::string at = "–";

    void add(double other, const std::string& name) {
        if (at == "–" || other > deviation) {
            deviation = other;
            at = name;
        }
    }
    std::string text() const { return at == "–" ? at : share_in_percent(deviation) + " (" + at + ")"; }
};

} // namespace

std::vector<ValidationCase> cie_171_cases(const std::vector<std::string>& starts) {
    std::vector<ValidationCase> all = cie_171_lamps();
    for (ValidationCase& one : cie_171_daylight()) {
        all.push_back(std::move(one));
    }
    for (const std::string& start : starts) {
        if (std::none_of(all.begin(), all.end(),
                         [&](const ValidationCase& one) { return one.name.starts_with(start); })) {
            std::string names, last;
            for (const ValidationCase& one : all) {
                const std::string words = one.name.substr(0, one.name.find(','));
                names += words == last ? "" : (names.empty() ? "" : "; ") + words;
                last = words;
            }
            throw UsageError("--case " + start + ": no case of cie-171 begins so (" + names + ")");
        }
    }
    if (!starts.empty()) {
        std::erase_if(all, [&](const ValidationCase& one) { return !starts_with_one_of(one.name, starts); });
    }
    return all;
}

ValidationResult validate(const Registry& registry, const ValidationCase& one, const BakeOptions& options,
                          const Execution& execution) {
    ValidationResult result{one.name, one.unit, one.readings, {}, 0, 0, 0.0};
    result.values.resize(one.readings.size());
    BakeOptions own = options;
    own.at.clear();
    if (!(own.output_spacing > 0.0)) {
        own.output_spacing = one.scene.mesh.diameter();
    }
    struct Entry {
        std::size_t reading = 0;
        double weight = 0.0; ///< 0: a sensor
    };
    std::vector<Entry> entries;
    for (std::size_t r = 0; r < one.readings.size(); ++r) {
        const ValidationReading& reading = one.readings[r];
        for (std::size_t k = 0; k < reading.places.size(); ++k) {
            own.at.push_back(reading.places[k]);
            entries.push_back({r, reading.weight[k]});
        }
        if (reading.places.size() == 1 && one.exact) {
            const ListedPoint& place = reading.places.front();
            const Vec3 n = place.normal.value(), x = place.position + ahead_of_the_surface * n;
            own.at.push_back({x, n});
            entries.push_back({r, 0.0});
            result.values[r].sensor_exact = one.exact(x, n);
        }
    }
    const auto begin = std::chrono::steady_clock::now();
    const BakeResult baked = bake(registry, one.scene, one.name, own, execution);
    result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    result.sites = baked.sites->size();
    result.rays = baked.options.rays;
    const Values& surface = one.indirect ? baked.listed_values.H_indirect : baked.listed_values.H;
    for (std::size_t i = 0; i < baked.listed.size(); ++i) {
        const Entry& entry = entries[baked.listed_number[i]];
        DIFUSA_REQUIRE(entry.weight != 0.0);
        result.values[entry.reading].surface +=
            entry.weight * one.unit_of_watts * surface.row(static_cast<Eigen::Index>(i)).mean();
    }
    const Values& sensed = one.indirect ? baked.readings.H_indirect : baked.readings.H;
    for (std::size_t i = 0; i < baked.sensors.size(); ++i) {
        const Entry& entry = entries[baked.sensors[i].listed];
        DIFUSA_REQUIRE(entry.weight == 0.0);
        const auto row = static_cast<Eigen::Index>(i);
        ValidationValue& value = result.values[entry.reading];
        value.sensor = one.unit_of_watts * sensed.row(row).mean();
        if (baked.readings.error.rows() > 0) {
            value.sensor_error = one.unit_of_watts * baked.readings.error(row, 0);
        }
    }
    return result;
}

double validation_deviation(const ValidationResult& result, double value, double right) {
    double largest = 0.0;
    for (const ValidationReading& reading : result.readings) {
        largest = std::max(largest, reading.exact);
    }
    const double unit = std::max(right, 0.01 * largest);
    return unit > 0.0 ? std::abs(value - right) / unit : 0.0;
}

std::string validation_header() {
    return "| case | readings | surface | sensors | error over estimate | report | within 5 % of it | doubtful |\n"
           "|---|---|---|---|---|---|---|---|\n";
}

std::string validation_row(const ValidationResult& result) {
    Largest surface, sensors, report;
    double true_squares = 0.0, estimated_squares = 0.0, squares = 0.0;
    std::size_t published = 0, passed = 0, doubtful = 0;
    for (std::size_t r = 0; r < result.readings.size(); ++r) {
        const ValidationReading& reading = result.readings[r];
        const ValidationValue& value = result.values[r];
        surface.add(validation_deviation(result, value.surface, reading.exact), reading.name);
        if (value.sensor) {
            sensors.add(validation_deviation(result, *value.sensor, value.sensor_exact), reading.name);
            const double error = *value.sensor - value.sensor_exact;
            true_squares += error * error;
            estimated_squares += value.sensor_error * value.sensor_error;
            squares += value.sensor_exact * value.sensor_exact;
        }
        if (reading.published && reading.doubtful) {
            ++doubtful;
        } else if (reading.published) {
            ++published;
            report.add(validation_deviation(result, *reading.published, reading.exact), reading.name);
            passed += validation_deviation(result, value.sensor.value_or(value.surface), *reading.published) <= 0.05;
        }
    }
    char ratio[32] = "–";
    if (std::max(true_squares, estimated_squares) > 1e-10 * squares) {
        std::snprintf(ratio, sizeof ratio, "%.2f", std::sqrt(true_squares / estimated_squares));
    }
    const std::string share = published == 0 ? "–" : std::to_string(passed) + " of " + std::to_string(published);
    return "| " + result.name + " | " + std::to_string(result.readings.size()) + " | " + surface.text() + " | " +
           sensors.text() + " | " + ratio + " | " + report.text() + " | " + share + " | " + std::to_string(doubtful) +
           " |\n";
}

std::string validation_csv_header() {
    return "case,reading,unit,exact,surface,sensor,sensor_exact,sensor_error,published,doubtful,sites,rays,seconds\n";
}

std::string validation_csv_rows(const ValidationResult& result) {
    std::string text;
    for (std::size_t r = 0; r < result.readings.size(); ++r) {
        const ValidationReading& reading = result.readings[r];
        const ValidationValue& value = result.values[r];
        text += "\"" + result.name + "\"," + reading.name + "," + result.unit + "," + text_of(reading.exact) + "," +
                text_of(value.surface) + ",";
        text += value.sensor ? text_of(*value.sensor) + "," + text_of(value.sensor_exact) + "," +
                                   text_of(value.sensor_error) + ","
                             : ",,,";
        text += (reading.published ? text_of(*reading.published) : "") + "," + (reading.doubtful ? "1" : "0") + "," +
                std::to_string(result.sites) + "," + std::to_string(result.rays) + "," + text_of(result.seconds) + "\n";
    }
    return text;
}

} // namespace difusa
