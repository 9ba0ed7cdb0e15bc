// What a bake tells people in the terminal.
#include <difusa/output/bake_files.h>

#include <difusa/bake/sensing.h>
#include <difusa/core/memory.h>
#include <difusa/core/photometry.h>
#include <difusa/core/text.h>
#include <difusa/output/text_table.h>
#include <difusa/output/thermal_files.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iomanip>
#include <sstream>
#include <utility>

namespace difusa {

std::string format_seconds(double seconds) {
    std::array<char, 32> text{};
    if (seconds < 120.0) {
        std::snprintf(text.data(), text.size(), "%.*f s", seconds < 1.0 ? 2 : seconds < 10.0 ? 1 : 0, seconds);
    } else if (seconds < 2.0 * 3600.0) {
        std::snprintf(text.data(), text.size(), "%.0f min", seconds / 60.0);
    } else {
        std::snprintf(text.data(), text.size(), "%.1f h", seconds / 3600.0);
    }
    return text.data();
}

namespace {

/// The line of a dry run: the whole, and the longest phases.
std::string predicted_time(const BakeEstimate& estimate) {
    if (estimate.phases.empty()) {
        return "time: unknown\n";
    }
    std::vector<std::pair<double, std::string>> longest;
    double all = 0.0;
    for (const auto& [phase, seconds] : estimate.phases) {
        longest.emplace_back(seconds, phase);
        all += seconds;
    }
    std::stable_sort(longest.begin(), longest.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    std::string text = "time: about " + format_seconds(all);
    const std::size_t named = std::min<std::size_t>(longest.size(), 4);
    for (std::size_t i = 0; i < named; ++i) {
        text += (i == 0 ? ", of which " : ", ") + longest[i].second + " " + format_seconds(longest[i].first);
    }
    return text + "\n";
}

/// Estimates and bound, relative to the root mean square of what is judged.
std::string error_sentence(const ErrorEstimate& error, bool thermal) {
    std::ostringstream text;
    const auto percent = [&](double value) { return error.reflected > 0.0 ? 100.0 * value / error.reflected : 0.0; };
    text << std::setprecision(2);
    if (thermal) {
        text << "error of the irradiance (rms): about " << error.total.rms << " W/m^2, below " << error.total.high
             << " W/m^2 with a confidence of 97.5 %; of its rms difference to the reference temperature, about "
             << percent(error.total.rms) << " %, below " << percent(error.total.high) << " % (" << error.points
             << " points); ";
    } else if (error.points == 0) {
        return "error: none of the radiosity, since nothing is reflected; that of the irradiance is not estimated "
               "(sensors "
               "estimate theirs: --grid, or --at with normals)";
    } else {
        text << "error (rms, of the rms reflected radiosity): about " << percent(error.total.rms) << " %, below "
             << percent(error.total.high) << " % with a confidence of 97.5 %; indirect light about "
             << percent(error.indirect.rms) << " %, below " << percent(error.indirect.high) << " % (" << error.points
             << " points); ";
    }
    if (percent(error.bound) <= 100.0) {
        text << "bound from the residual: " << percent(error.bound) << " %";
    } else if (std::isfinite(error.bound)) {
        text << "no useful bound from the residual (it is divided by the least absorptance, "
             << 1.0 - error.largest_reflectance << "); more sites and rays would tighten it";
    } else {
        text << "no proven bound, since "
             << (thermal ? "the net flux of some surface is prescribed, or its emissivity is 0"
                         : "some surface absorbs nothing");
    }
    return text.str();
}

std::string energy_sentence(const EnergyBalance& energy, bool photometric) {
    std::ostringstream text;
    Eigen::Index channel = 0;
    energy.imbalance.abs().maxCoeff(&channel);
    const double lost = energy.imbalance[channel];
    const auto all = [photometric](const Eigen::ArrayXd& power) { // of one channel, or of three
        const double watts = photometric && power.size() == 3 ? power.matrix().dot(luminance_weights) : power.mean();
        return photometric ? lumens_per_watt * watts : watts;
    };
    text << std::setprecision(4) << (photometric ? "luminous flux (lm)" : "energy (W, mean of the channels)")
         << ": emitted " << all(energy.emitted) << ", from suns and point lights " << all(energy.from_lights)
         << ", from the sky " << all(energy.from_sky) << ", absorbed " << all(energy.absorbed) << ", escaped "
         << all(energy.escaped) << ", lost on back faces " << all(energy.blocked) << "; " << std::setprecision(2)
         << 100.0 * std::abs(lost) << " % " << (lost < 0.0 ? "created" : "lost") << " by the discretisation\n";
    return text.str();
}

std::string grid_sentence(const BakeResult& result, std::size_t number) {
    const GridSummary grid = summary_of_grid(result, number);
    std::ostringstream text;
    text << std::setprecision(4) << "grid on " << result.options.grids[number].on << ": "
         << counted(grid.count, "sensor") << ", " << (result.photometric ? "illuminance (lx)" : "irradiance (W/m^2)")
         << " minimum " << grid.least << ", mean " << grid.mean << ", maximum " << grid.most
         << ", uniformity (minimum / mean) " << std::setprecision(3) << grid.uniformity;
    if (result.error) {
        text << std::setprecision(2) << "; error of a sensor (rms): about " << grid.error;
    }
    return text.str();
}

/// The corrected mean with its interval; one number if all channels are equal, and in lux.
std::string goal_sentence(const GoalEstimate& goal, bool photometric) {
    std::ostringstream text;
    const auto write = [&](const Rgb& c, int digits) {
        text << std::setprecision(digits);
        if (photometric) {
            text << lumens_per_watt * c.matrix().dot(luminance_weights);
            return;
        }
        const bool grey = c[0] == c[1] && c[1] == c[2];
        text << c[0];
        if (!grey) {
            text << ", " << c[1] << ", " << c[2];
        }
    };
    text << "goal \"" << goal.name << "\": mean " << (photometric ? "illuminance " : "irradiance ");
    write(goal.mean, 5);
    text << (photometric ? " lx, +/- " : " W/m^2, +/- ");
    write(0.5 * (goal.high - goal.low), 2);
    text << " with a confidence of 95 %; evaluated from the basis ";
    write(goal.field, 5);
    return text.str();
}

void tell_scene(const BakeResult& result, std::ostream& text) {
    const Mesh& mesh = result.scene->mesh;
    text << result.file << ": " << counted(result.diagnosis.file_faces, "face") << ", "
         << counted(mesh.triangles.size(), "triangle") << ", area " << mesh.area << ", "
         << counted(mesh.region_count, "region") << "\n";
    for (const Finding& finding : result.diagnosis.findings) {
        if (const std::string remark = finding.remark(); !remark.empty()) {
            text << remark << "\n";
        }
    }
    for (const std::string& note : result.journal.notes()) {
        text << "note: " << note << "\n";
    }
    text << "sites: " << (result.estimate.predicted ? "about " : "") << result.estimate.sites
         << (result.options.adaptive ? ", graded, as many as at spacing " : " at spacing ") << result.options.spacing
         << "\n";
    if (const Substructure* const parts = substructure_of(result)) {
        text << "elements: parts of " << parts->patches() << " patches, quartered up to " << parts->levels
             << " times in a row\n";
    }
}

void tell_prediction(const BakeResult& result, std::ostream& text) {
    const BakeEstimate& estimate = result.estimate;
    text << "rays: " << estimate.rays << ", visibility segments: at most " << estimate.segments << "\n"
         << "error estimate, first round" << (result.options.goals.empty() ? "" : ", goals")
         << (result.options.final_gather > 0 ? ", final gather: " : ": ") << estimate.further_rays << " rays\n"
         << "memory for transport: at most " << format_bytes(estimate.transport_bytes)
         << "; of the whole process: about " << format_bytes(estimate.peak_bytes) << "\n"
         << predicted_time(estimate);
}

void tell_transport(const BakeResult& result, std::ostream& text) {
    if (result.transport_file.empty()) {
        text << "transport: ";
    } else {
        text << "transport: loaded from " << result.transport_file << " (" << result.system->transport().rays
             << " rays); now ";
    }
    text << result.journal.count_of("rays") << " rays, " << result.journal.count_of("segments") << " segments, "
         << format_bytes(static_cast<double>(result.system->transport().bytes)) << "; spectral radius "
         << (result.solution.spectral_radius_is_bound ? "at most " : "about ") << result.solution.spectral_radius
         << "\n";
    if (!result.moved.empty()) {
        text << "moved: ";
        for (std::size_t i = 0; i < result.moved.size(); ++i) {
            text << (i == 0 ? "" : ", ") << result.moved[i].object;
        }
        if (result.recast) {
            text << " (rays from the sites: " << result.recast->anew << " cast anew, " << result.recast->kept
                 << " kept)";
        }
        text << "\n";
    }
    for (const Saving& saving : result.journal.savings()) {
        text << "not needed: " << saving.what << ", since " << saving.because << " ("
             << formatted("%.0f", saving.amount) << " " << saving.unit << " saved)\n";
    }
}

void tell_attempts(const BakeResult& result, std::ostream& text) {
    for (std::size_t i = 0; i < result.attempts.size(); ++i) {
        const Attempt& attempt = result.attempts[i];
        text << std::setprecision(2) << "attempt " << i + 1 << ": " << attempt.effort.sites << " sites, "
             << attempt.effort.rays << " rays, " << attempt.effort.error_points << " error points: about "
             << 100.0 * attempt.rms << " %, below " << 100.0 * attempt.high << " %";
        if (attempt.effort.shadow_rays != result.attempts.front().effort.shadow_rays) {
            text << "; " << attempt.effort.shadow_rays << " shadow rays";
        }
        if (attempt.goals) {
            text << "; goals with " << attempt.effort.goal_samples << " samples each: within " << 100.0 * *attempt.goals
                 << " %";
        }
        text << " (" << format_seconds(attempt.seconds) << ")\n";
    }
}

} // namespace

std::string summary_of(const BakeResult& result) {
    std::ostringstream text;
    tell_scene(result, text);
    if (result.dry_run) {
        tell_prediction(result, text);
        return text.str();
    }
    tell_transport(result, text);
    text << "solve: " << result.solution.solve.sentence() << "\n"
         << (result.thermal ? thermal_summary(result) : energy_sentence(result.solution.energy, result.photometric));
    tell_attempts(result, text);
    if (result.error) {
        text << error_sentence(*result.error, result.thermal.has_value()) << "\n";
    }
    for (std::size_t g = 0; g < result.options.grids.size(); ++g) {
        text << grid_sentence(result, g) << "\n";
    }
    for (const GoalEstimate& goal : result.goal_estimates) {
        text << goal_sentence(goal, result.photometric) << "\n";
    }
    double total = 0.0;
    for (const auto& [phase, took] : result.journal.seconds()) {
        total += took;
    }
    text << "time: " << format_seconds(total) << "; peak memory " << format_bytes(static_cast<double>(peak_memory()))
         << "\n";
    return text.str();
}

} // namespace difusa
