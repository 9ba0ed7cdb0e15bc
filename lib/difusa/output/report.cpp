#include <difusa/bake/sensing.h>
#include <difusa/core/memory.h>
#include <difusa/core/photometry.h>
#include <difusa/output/bake_files.h>
#include <difusa/output/thermal_files.h>
#include <difusa/version.h>

#include <nlohmann/json.hpp>

#include <cmath>

namespace difusa {

namespace {

using Json = nlohmann::ordered_json;

Json json_list(const Eigen::ArrayXd& values) {
    return std::vector<double>(values.data(), values.data() + values.size());
}

Json json_list(const Rgb& c) {
    return {c[0], c[1], c[2]};
}

const char* word(SolveSummary::Reason reason) {
    switch (reason) {
    case SolveSummary::Reason::converged:
        return "converged";
    case SolveSummary::Reason::max_iterations:
        return "max_iterations";
    case SolveSummary::Reason::diverged:
        return "diverged";
    case SolveSummary::Reason::stagnated:
        return "stagnated";
    }
    return "";
}

/// Null where there is no sharp light to carry over.
Json first_bounce_word(const std::optional<FirstBounce>& first_bounce) {
    return first_bounce ? Json(*first_bounce == FirstBounce::live ? "live" : "operator") : Json(nullptr);
}

/// Null if infinite.
Json json_number(double value) {
    return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json error_of(const ErrorEstimate& error, int channels) {
    const double share = 1.0 / std::sqrt(channels); // of the root of a sum over the channels: root mean square
    const auto interval_of = [share](const RmsEstimate& estimate) {
        return Json{{"rms", share * estimate.rms}, {"low", share * estimate.low}, {"high", share * estimate.high}};
    };
    return {{"unit", "W/m^2, root mean square over the area and the channels"},
            {"points", error.points},
            {"rays", error.rays},
            {"reflected", share * error.reflected},
            {"total", interval_of(error.total)},
            {"indirect", interval_of(error.indirect)},
            {"residual", interval_of(error.residual)},
            {"relative", error.reflected > 0.0 ? json_number(error.total.rms / error.reflected) : Json(nullptr)},
            {"relative_high", error.reflected > 0.0 ? json_number(error.total.high / error.reflected) : Json(nullptr)},
            {"gather_noise", share * error.noise},
            {"largest_reflectance", error.largest_reflectance},
            {"bound", json_number(share * error.bound)}};
}

Json goals_of(const BakeResult& result) {
    Json goals = Json::array();
    for (const GoalEstimate& goal : result.goal_estimates) {
        goals.push_back({{"name", goal.name},
                         {"unit", "irradiance, W/m^2"},
                         {"area", goal.places == 0 ? Json(goal.area) : Json(nullptr)},
                         {"places", goal.places},
                         {"mean", json_list(goal.mean)},
                         {"low", json_list(goal.low)},
                         {"high", json_list(goal.high)},
                         {"field", json_list(goal.field)},
                         {"rays", goal.rays},
                         {"segments", goal.segments}});
    }
    return goals;
}

Json factors_of(const BakeResult& result) {
    Json factors = Json::array();
    for (const auto& [group, factor] : result.light_factors) {
        factors.push_back({{"light_group", group}, {"factor", factor}});
    }
    return factors;
}

Json target_of(const BakeResult& result) {
    const ErrorTarget& target = *result.options.target;
    Json attempts = Json::array();
    for (const Attempt& attempt : result.attempts) {
        attempts.push_back({{"sites", attempt.effort.sites},
                            {"rays", attempt.effort.rays},
                            {"shadow_rays", attempt.effort.shadow_rays},
                            {"error_points", attempt.effort.error_points},
                            {"goal_samples", attempt.goals ? Json(attempt.effort.goal_samples) : Json(nullptr)},
                            {"goals_relative_half_width", attempt.goals ? json_number(*attempt.goals) : Json(nullptr)},
                            {"relative", attempt.rms},
                            {"relative_high", attempt.high},
                            {"noise_share", attempt.noise_share},
                            {"shadow_noise_share", attempt.shadow_noise_share},
                            {"seconds", attempt.seconds}});
    }
    return {{"relative", target.relative},      {"of", result.options.goals.empty() ? "field" : "goals"},
            {"most_sites", target.most_sites},  {"most_seconds", json_number(target.most_seconds)},
            {"reached", !result.target_missed}, {"attempts", attempts}};
}

Json input_of(const BakeResult& result) {
    Json input;
    input["file"] = result.file;
    input["faces"] = result.diagnosis.file_faces;
    input["points"] = result.diagnosis.file_points;
    const std::vector<SoupPart>& parts = result.diagnosis.parts;
    input["parts"] = Json::array();
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const std::size_t end = i + 1 < parts.size() ? parts[i + 1].first_face : result.diagnosis.file_faces;
        input["parts"].push_back(
            {{"file", parts[i].file}, {"first_face", parts[i].first_face}, {"faces", end - parts[i].first_face}});
    }
    input["findings"] = Json::array();
    for (const Finding& finding : result.diagnosis.findings) {
        input["findings"].push_back({{"code", finding.code},
                                     {"count", finding.count},
                                     {"repaired", finding.repaired},
                                     {"remedy", finding.remedy},
                                     {"places", finding.places}});
    }
    return input;
}

Json options_of(const BakeResult& result) {
    const BakeOptions& options = result.options;
    Json chosen;
    for (const auto& [kind, choice] : result.plugins) {
        chosen[kind] = choice;
    }
    chosen["quality"] = options.quality.empty() ? Json(nullptr) : Json(options.quality);
    chosen["spacing"] = options.spacing;
    chosen["sites"] = options.sites == 0 ? Json(nullptr) : Json(options.sites);
    chosen["adaptive"] = options.adaptive;
    chosen["levels"] =
        substructure_of(result) != nullptr ? Json(options.levels.value_or(default_levels)) : Json(nullptr);
    chosen["neighbours"] = options.neighbours;
    chosen["rays"] = options.rays;
    chosen["tolerance"] = options.solve.tolerance;
    chosen["max_iterations"] = options.solve.max_iterations;
    chosen["direct"] = options.direct;
    chosen["final_gather"] = options.final_gather;
    chosen["shadow_rays"] = options.shadow_rays;
    chosen["error_points"] = options.error_points ? Json(*options.error_points) : Json(nullptr);
    chosen["goal_samples"] = options.goals.empty() ? Json(nullptr) : Json(options.goal_samples);
    chosen["reflectance"] = json_list(options.reflectance.value_or(Material{}.reflectance));
    chosen["sky"] = json_list(result.scene->sky);
    chosen["suns"] = Json::array();
    for (const Sun& sun : result.scene->suns) {
        chosen["suns"].push_back(
            {{"towards", json_list(Rgb(sun.towards))}, {"irradiance", json_list(sun.irradiance)}, {"disc", sun.disc}});
    }
    chosen["point_lights"] = Json::array();
    for (const PointLight& light : result.scene->point_lights) {
        chosen["point_lights"].push_back({{"position", json_list(Rgb(light.position))},
                                          {"intensity", json_list(light.intensity)},
                                          {"direction", json_list(Rgb(light.direction))},
                                          {"cos_inner", light.cos_inner},
                                          {"cos_outer", light.cos_outer}});
        if (light.distribution) {
            chosen["point_lights"].back()["luminaire"] = {
                {"c0", json_list(Rgb(light.c0))},
                {"flux", light.distribution->flux() / light.distribution->largest()},
                {"opening", {2.0 * light.half_length, 2.0 * light.half_width}},
                {"round", light.is_round}};
        }
    }
    chosen["sky_dome"] = result.scene->dome != nullptr;
    chosen["light_groups"] = Json::array();
    if (result.has_groups()) {
        chosen["light_groups"] = result.field().sets().names;
    }
    chosen["units"] = result.photometric ? "photometric" : "radiometric";
    chosen["luminance_weights"] = json_list(Rgb(luminance_weights.array()));
    chosen["lumens_per_watt"] = lumens_per_watt;
    chosen["flip"] = options.flip;
    chosen["sensor"] = options.sensor;
    chosen["sensor_rays"] = options.sensor_rays;
    chosen["face_centres"] = options.face_centres;
    chosen["output_spacing"] = options.output_spacing;
    chosen["seed"] = options.seed;
    chosen["threads"] = result.threads;
    return chosen;
}

/// What is not where the file has it; null if nothing was moved.
Json moved_of(const BakeResult& result) {
    if (result.moved.empty()) {
        return nullptr;
    }
    Json moved;
    for (const MovedObject& each : result.moved) {
        Json matrix = Json::array();
        for (Eigen::Index row = 0; row < 3; ++row) {
            const Eigen::Matrix3d& R = each.motion.rotation;
            matrix.push_back({R(row, 0), R(row, 1), R(row, 2), each.motion.offset[row]});
        }
        moved["objects"].push_back({{"object", each.object}, {"matrix", matrix}});
    }
    moved["rays_cast_anew"] = result.recast ? result.recast->anew : 0;
    moved["rays_kept"] = result.recast ? result.recast->kept : result.system->transport().rays;
    return moved;
}

Json transport_of(const BakeResult& result) {
    Json transport;
    transport["channels"] = result.channels;
    transport["estimated_rays"] = result.estimate.rays;
    transport["estimated_segments"] = result.estimate.segments;
    transport["estimated_bytes"] = result.estimate.transport_bytes;
    if (result.dry_run) {
        transport["estimated_further_rays"] = result.estimate.further_rays;
        transport["estimated_peak_memory_bytes"] = result.estimate.peak_bytes;
    } else {
        transport["rays"] = result.journal.count_of("rays");
        transport["segments"] = result.journal.count_of("segments");
        transport["projection_points"] = result.system->discretisation().points.size();
        transport["loaded_from"] = result.transport_file.empty() ? Json(nullptr) : Json(result.transport_file);
        transport["moved"] = moved_of(result);
        transport["first_bounce"] = first_bounce_word(result.solution.first_bounce);
        transport["area_light_triangles"] = result.solution.area_lights;
        transport["surfels"] = result.system->discretisation().surfels->size();
        transport["bytes"] = result.system->transport().bytes;
        transport["bytes_of_averages"] = result.system->discretisation().averages->bytes();
        transport["largest_row_sum"] = result.system->transport().largest_row_sum({});
        transport["mean_share_of_exact_form_factors"] = result.analytic_share;
        transport["mean_share_on_backs"] = result.mean_back;
        if (result.scene->mesh.mirrors.any() || !result.scene->mesh.repetition.endless.empty()) {
            transport["mirror_depth"] = result.options.mirror_depth;
            transport["mean_share_cut_off_in_mirrors"] = result.mean_cut_off;
        }
        if (result.glossy) {
            transport["gloss"] = {{"directional_order", result.options.directional_order},
                                  {"elements", result.glossy->elements},
                                  {"reflections", result.glossy->reflections},
                                  {"resolved_share_of_sharpest_lobe", result.glossy->resolved}};
        }
        transport["condition"] = result.system->discretisation().projection->condition();
        transport["constant_error"] = result.constant_error;
        transport["spectral_radius"] = result.solution.spectral_radius;
        transport["spectral_radius_is_bound"] = result.solution.spectral_radius_is_bound;
    }
    return transport;
}

/// Null unless the scene is a thermal one.
Json thermal_of(const BakeResult& result) {
    if (!result.thermal) {
        return nullptr;
    }
    const ThermalSetting& setting = *result.scene->thermal;
    Json surfaces = Json::array();
    for (const ThermalSurface& surface : result.thermal->surfaces) {
        const Material& material = result.scene->materials[surface.material];
        surfaces.push_back({{"material", material.name},
                            {"given", given_word(material)},
                            {"emissivity", material.thermal ? material.thermal->emissivity : 0.0},
                            {"area", surface.area},
                            {"temperature", surface.mean_temperature},
                            {"least_temperature", surface.least_temperature},
                            {"largest_temperature", surface.largest_temperature},
                            {"net_flux", surface.area > 0.0 ? surface.heat / surface.area : 0.0},
                            {"net_heat", surface.heat},
                            {"radiosity", surface.radiosity},
                            {"irradiance", surface.irradiation},
                            {"error_of_irradiance", result.errors ? Json(surface.error) : Json(nullptr)}});
    }
    return {{"units", "K, W/m^2, W, m^2; net fluxes and heats are positive if they leave the surface"},
            {"surroundings", setting.surroundings ? Json(*setting.surroundings) : Json(nullptr)},
            {"reference", setting.reference},
            {"surfaces", surfaces},
            {"net_heat", result.thermal->heat},
            {"to_surroundings", result.thermal->to_surroundings},
            {"to_backs_and_between_mirrors", result.thermal->to_backs},
            {"imbalance", result.thermal->imbalance()},
            {"exchanged", result.thermal->exchanged}};
}

/// What only a full bake has, not a dry run.
void add_outcome(const BakeResult& result, Json& report) {
    report["solve"] = {{"reason", word(result.solution.solve.reason)},
                       {"iterations", result.solution.solve.iterations},
                       {"residual", result.solution.solve.residual},
                       {"residual_history", result.solution.solve.residual_history},
                       {"stop", result.options.stop},
                       {"entries_touched", result.solution.solve.entries_touched}};
    if (result.solution.solve.change) {
        report["solve"]["change"] = *result.solution.solve.change;
    }
    const EnergyBalance& energy = result.solution.energy;
    report["energy"] = {
        {"unit", "W, one number per channel"},          {"emitted", json_list(energy.emitted)},
        {"from_lights", json_list(energy.from_lights)}, {"from_sky", json_list(energy.from_sky)},
        {"absorbed", json_list(energy.absorbed)},       {"escaped", json_list(energy.escaped)},
        {"ended_on_backs", json_list(energy.blocked)},  {"cut_off_in_mirrors", json_list(energy.cut_off)},
        {"imbalance", json_list(energy.imbalance)}};
    report["not_needed"] = Json::array();
    for (const Saving& saving : result.journal.savings()) {
        report["not_needed"].push_back(
            {{"what", saving.what}, {"because", saving.because}, {"saved", saving.amount}, {"unit", saving.unit}});
    }
    report["grids"] = Json::array();
    for (std::size_t g = 0; g < result.options.grids.size(); ++g) {
        const SensorGrid& grid = result.options.grids[g];
        const GridSummary summary = summary_of_grid(result, g);
        report["grids"].push_back({{"on", grid.on},
                                   {"height", grid.height},
                                   {"spacing", grid.spacing},
                                   {"margin", grid.margin},
                                   {"sensor", result.options.sensor},
                                   {"sensors", summary.count},
                                   {"unit", result.photometric ? "lx" : "W/m^2"},
                                   {"minimum", summary.least},
                                   {"mean", summary.mean},
                                   {"maximum", summary.most},
                                   {"uniformity", summary.uniformity},
                                   {"error_estimate", result.error ? Json(summary.error) : Json(nullptr)}});
    }
    report["thermal"] = thermal_of(result);
    report["error"] = result.error ? error_of(*result.error, result.channels) : Json(nullptr);
    report["error_target"] = result.options.target ? target_of(result) : Json(nullptr);
    report["goals"] = goals_of(result);
    report["light_factors"] = factors_of(result);
    report["output"] = {{"vertices", result.mesh.vertices.size()},
                        {"triangles", result.mesh.triangles.size()},
                        {"rays", result.journal.count_of("output rays")},
                        {"segments", result.journal.count_of("output segments")},
                        {"display_exposure", display_exposure(result)}};
}

} // namespace

std::string report_of(const BakeResult& result) {
    const bool baked = !result.dry_run;
    Json report;
    report["schema"] = "difusa-bake-report";
    report["schema_version"] = 4;
    report["difusa_version"] = version();
    for (const auto& [name, number] : library_versions()) {
        report["library_versions"][name] = number;
    }
    report["dry_run"] = !baked;

    report["input"] = input_of(result);
    const Mesh& mesh = result.scene->mesh;
    report["mesh"] = {{"triangles", mesh.triangles.size()}, {"points", mesh.points.size()},
                      {"regions", mesh.region_count},       {"area", mesh.area},
                      {"low", json_list(Rgb(mesh.low))},    {"high", json_list(Rgb(mesh.high))}};
    report["notes"] = result.journal.notes();

    report["options"] = options_of(result);
    report["sites"] = {{"count", result.estimate.sites}, {"spacing", result.options.spacing}};
    if (const Substructure* const parts = substructure_of(result)) {
        report["sites"]["subdivision"] = {{"patches", parts->patches()}, {"levels", parts->levels}};
    }
    report["transport"] = transport_of(result);
    const auto times = [](const std::vector<std::pair<std::string, double>>& phases) {
        Json list = Json::array();
        for (const auto& [phase, took] : phases) {
            list.push_back({{"phase", phase}, {"seconds", took}});
        }
        return list;
    };
    if (baked) {
        add_outcome(result, report);
    } else {
        report["estimated_seconds"] = times(result.estimate.phases);
    }
    report["seconds"] = times(result.journal.seconds());
    report["peak_memory_bytes"] = peak_memory();
    return report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

} // namespace difusa
