#include <difusa/output/bake_files.h>

#include <difusa/bake/saved_transport.h>
#include <difusa/bake/sensing.h>
#include <difusa/bake/thermal.h>
#include <difusa/core/memory.h>
#include <difusa/core/photometry.h>
#include <difusa/io/field_writers.h>
#include <difusa/output/error_chart.h>
#include <difusa/output/point_table.h>
#include <difusa/output/text_table.h>
#include <difusa/output/thermal_files.h>
#include <difusa/version.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <iomanip>
#include <memory>
#include <sstream>
#include <utility>

namespace difusa {

namespace {

const std::vector<std::string> rgb{"R", "G", "B"};
const char* const flux = "W/m^2";

FieldArray colour(const std::string& name, const std::string& unit, Values values) {
    return {name, unit, rgb, std::move(values)};
}

/// One that refers to the values.
FieldArray colour_view(const std::string& name, const std::string& unit, const Values& values) {
    return {name, unit, rgb, std::cref(values)};
}

FieldArray scalar_view(const std::string& name, const std::string& unit, const Values& values) {
    return {name, unit, {}, std::cref(values)};
}

FieldArray scalar(const std::string& name, const std::string& unit, const std::vector<double>& values) {
    const Values column = Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
    return {name, unit, {}, column};
}

FieldArray numbers(const std::string& name, std::vector<std::int32_t> values) {
    return {name, "", {}, std::move(values)};
}

std::vector<double> as_vector(const Rgb& c) {
    return {c[0], c[1], c[2]};
}

std::vector<FieldArray> arrays_of(const PointValues& values) {
    return {colour_view("radiosity", flux, values.B),
            colour_view("irradiance", flux, values.H),
            colour_view("irradiance_direct", flux, values.H_direct),
            colour_view("irradiance_indirect", flux, values.H_indirect),
            colour_view("reflectance", "", values.rho),
            colour_view("emission", flux, values.E)};
}

/// For eyes, and for programs that colour by one number: the magnitude of R, G and B means nothing.
void add_scalars(const BakeResult& result, const Values& B, const Values& H, std::vector<FieldArray>& arrays) {
    if (result.photometric) {
        arrays.push_back({"luminance", "cd/m^2", {}, luminance_of_diffuse(B)});
        arrays.push_back({"illuminance", "lx", {}, illuminance_of(H)});
    } else {
        arrays.push_back({"radiosity_weighted", flux, {}, Values(B * luminance_weights)});
        arrays.push_back({"irradiance_weighted", flux, {}, Values(H * luminance_weights)});
    }
}

void add_scalars(const BakeResult& result, const PointValues& values, std::vector<FieldArray>& arrays) {
    add_scalars(result, values.B, values.H, arrays);
    if (result.photometric) {
        arrays.push_back({"illuminance_direct", "lx", {}, illuminance_of(values.H_direct)});
        arrays.push_back({"illuminance_indirect", "lx", {}, illuminance_of(values.H_indirect)});
    }
}

void add_groups(const BakeResult& result, const PointValues& values, std::vector<FieldArray>& arrays) {
    for (const GroupValues& group : values.groups) {
        arrays.push_back(colour_view("radiosity_of_" + group.name, flux, group.B));
        arrays.push_back(colour_view("irradiance_of_" + group.name, flux, group.H));
        if (result.photometric) {
            arrays.push_back({"illuminance_of_" + group.name, "lx", {}, illuminance_of(group.H)});
        }
    }
}

/// Suns, point lights and light groups, if any.
void add_lights(const BakeResult& result, std::vector<FieldNote>& notes) {
    std::vector<double> suns; // direction towards it and irradiance, six numbers each
    for (const Sun& sun : result.scene->suns) {
        suns.insert(suns.end(), sun.towards.data(), sun.towards.data() + 3);
        suns.insert(suns.end(), sun.irradiance.data(), sun.irradiance.data() + 3);
    }
    if (!suns.empty()) {
        notes.push_back({"suns", suns});
    }
    std::vector<double> point_lights; // position, intensity, axis and the cosines of the cone, eleven numbers each
    for (const PointLight& light : result.scene->point_lights) {
        for (const Vec3& v : {light.position, Vec3(light.intensity), light.direction}) {
            point_lights.insert(point_lights.end(), v.begin(), v.end());
        }
        point_lights.insert(point_lights.end(), {light.cos_inner, light.cos_outer});
    }
    if (!point_lights.empty()) {
        notes.push_back({"point_lights", point_lights});
    }
    if (result.has_groups()) {
        std::string names;
        for (const std::string& group : result.field().sets().names) {
            names += (names.empty() ? "" : "\n") + group;
        }
        notes.push_back({"light_groups", names});
    }
}

/// Options and results recorded in every file of a bake.
std::vector<FieldNote> notes_of(const BakeResult& result) {
    std::vector<FieldNote> notes;
    notes.push_back({"difusa_version", version()});
    std::string libraries;
    for (const auto& [name, number] : library_versions()) {
        libraries += (libraries.empty() ? "" : ", ") + name + " " + number;
    }
    notes.push_back({"library_versions", libraries});
    notes.push_back({"input", result.file});
    for (const auto& [kind, choice] : result.plugins) {
        notes.push_back({kind, choice});
    }
    const BakeOptions& options = result.options;
    const auto number = [&](const char* name, double value) { notes.push_back({name, std::vector<double>{value}}); };
    notes.push_back({"seed", std::to_string(options.seed)}); // a double cannot hold all 64 bits
    number("spacing", result.sites->spacing);
    number("sites", static_cast<double>(result.sites->size()));
    number("neighbours", options.neighbours);
    number("rays_per_site", static_cast<double>(options.rays));
    notes.push_back({"direct", options.direct});
    number("final_gather", static_cast<double>(options.final_gather));
    number("error_points", static_cast<double>(options.error_points.value_or(0)));
    number("crease_angle", options.crease_angle);
    add_lights(result, notes);
    if (result.error) {
        const double share = 1.0 / std::sqrt(result.channels);
        number("error", share * result.error->total.rms);
        number("error_high", share * result.error->total.high);
        if (std::isfinite(result.error->bound)) {
            number("error_bound", share * result.error->bound);
        }
    }
    notes.push_back({"units", std::string(result.photometric ? "photometric" : "radiometric")});
    notes.push_back({"luminance_weights", as_vector(Rgb(luminance_weights.array()))});
    if (result.photometric) {
        number("lumens_per_watt", lumens_per_watt);
    }
    notes.push_back({"default_reflectance", as_vector(options.reflectance.value_or(Material{}.reflectance))});
    notes.push_back({"sky", as_vector(result.scene->sky)});
    notes.push_back({"up", std::vector<double>(result.up.begin(), result.up.end())});
    if (result.scene->thermal) {
        const std::vector<FieldNote> thermal = thermal_notes(result);
        notes.insert(notes.end(), thermal.begin(), thermal.end());
    }
    number("output_spacing", options.output_spacing);
    number("tolerance", options.solve.tolerance);
    number("max_iterations", options.solve.max_iterations);
    number("iterations", result.solution.solve.iterations);
    number("residual", result.solution.solve.residual);
    number("spectral_radius", result.solution.spectral_radius);
    std::vector<double> seconds;
    std::string phases;
    for (const auto& [phase, took] : result.journal.seconds()) {
        phases += (phases.empty() ? "" : ", ") + phase;
        seconds.push_back(took);
    }
    notes.push_back({"phases", phases});
    notes.push_back({"phase_seconds", seconds});
    std::string names;
    for (const Material& material : result.scene->materials) {
        names += (names.empty() ? "" : "\n") + material.name;
    }
    notes.push_back({"material_names", names});
    std::string remarks; // a single array: readers keep only one per name
    for (const std::string& note : result.journal.notes()) {
        remarks += (remarks.empty() ? "" : "\n") + note;
    }
    if (!remarks.empty()) {
        notes.push_back({"notes", remarks});
    }
    return notes;
}

} // namespace

double display_exposure(const BakeResult& result) {
    const std::size_t count = result.mesh.vertices.size();
    std::vector<double> area(count, 0.0);
    double total = 0.0;
    for (const auto& triangle : result.mesh.triangles) {
        const Vec3 a = result.mesh.vertices[triangle[0]].position;
        const double third = (result.mesh.vertices[triangle[1]].position - a)
                                 .cross(result.mesh.vertices[triangle[2]].position - a)
                                 .norm() /
                             6.0;
        for (const Index v : triangle) {
            if ((result.output.E.row(static_cast<Eigen::Index>(v)).array() == 0.0).all()) {
                area[v] += third;
                total += third;
            }
        }
    }
    std::vector<std::pair<double, double>> shares; // luminance, area
    for (std::size_t v = 0; v < count; ++v) {
        if (area[v] > 0.0) {
            shares.emplace_back(result.output.B.row(static_cast<Eigen::Index>(v)).dot(luminance_weights), area[v]);
        }
    }
    std::sort(shares.begin(), shares.end());
    double below = 0.0, bright = 0.0;
    for (const auto& [luminance, share] : shares) {
        bright = luminance;
        below += share;
        if (below >= 0.95 * total) {
            break;
        }
    }
    return bright > 0.0 ? 0.9 / bright : 1.0;
}

namespace {

/// Light at the vertices, and colours that show it.
void add_light(const BakeResult& result, std::optional<double> chosen_exposure, FieldFile& field) {
    const auto count = static_cast<Eigen::Index>(result.mesh.vertices.size());
    const double exposure = chosen_exposure ? *chosen_exposure : display_exposure(result);
    std::vector<std::uint8_t> display(static_cast<std::size_t>(3 * count));
    for (Eigen::Index v = 0; v < count; ++v) {
        for (Eigen::Index c = 0; c < 3; ++c) {
            display[static_cast<std::size_t>(3 * v + c)] =
                static_cast<std::uint8_t>(std::lround(255.0 * srgb(exposure * result.output.B(v, c))));
        }
    }
    field.point_arrays = arrays_of(result.output);
    add_scalars(result, result.output, field.point_arrays);
    field.point_arrays.push_back({"display_rgb", "", rgb, std::move(display)});
    field.notes.push_back({"display_exposure", std::vector<double>{exposure}});
    field.active_colours = "display_rgb";
    field.quality = result.photometric ? "luminance" : "radiosity_weighted";
}

} // namespace

FieldFile field_of(const BakeResult& result, std::optional<double> chosen_exposure) {
    FieldFile field;
    for (const SurfacePoint& vertex : result.mesh.vertices) {
        field.points.push_back(vertex.position);
        field.normals.push_back(vertex.normal);
    }
    field.triangles = result.mesh.triangles;

    field.notes = notes_of(result);
    if (result.thermal) {
        field.point_arrays = thermal_arrays(result.thermal->at_vertices);
        field.quality = "temperature";
    } else {
        add_light(result, chosen_exposure, field);
    }
    std::vector<std::int32_t> face(result.mesh.face.size()), material(result.mesh.face.size());
    for (std::size_t f = 0; f < face.size(); ++f) {
        face[f] = static_cast<std::int32_t>(result.scene->mesh.original_face[result.mesh.face[f]]);
        material[f] = static_cast<std::int32_t>(result.scene->mesh.material[result.mesh.face[f]]);
    }
    if (result.errors) {
        field.point_arrays.push_back(scalar_view("error_estimate", flux, result.errors->error));
        field.point_arrays.push_back(scalar_view("error_noise", flux, result.errors->noise));
        field.point_arrays.push_back(scalar_view("error_discretisation", flux, result.errors->discretisation));
        if (knows_error_of_irradiance(result)) {
            field.point_arrays.push_back(scalar_view("irradiance_error", flux, result.errors->irradiance));
            if (result.photometric) {
                field.point_arrays.push_back(
                    {"illuminance_error", "lx", {}, Values(lumens_per_watt * result.errors->irradiance)});
            }
        }
    }
    field.cell_arrays = {numbers("original_face_id", std::move(face)), numbers("material_id", std::move(material))};
    add_groups(result, result.output, field.point_arrays);
    if (result.thermal && result.thermal->at_centres) {
        const std::vector<FieldArray> centres = thermal_arrays(*result.thermal->at_centres);
        field.cell_arrays.insert(field.cell_arrays.end(), centres.begin(), centres.end());
    } else if (result.centres && !result.thermal) {
        const std::vector<FieldArray> centres = arrays_of(*result.centres);
        field.cell_arrays.insert(field.cell_arrays.end(), centres.begin(), centres.end());
        add_scalars(result, *result.centres, field.cell_arrays);
        add_groups(result, *result.centres, field.cell_arrays);
    }
    return field;
}

namespace {

/// The state at the sites.
void add_thermal_sites(const BakeResult& result, FieldFile& field) {
    std::vector<Index> material;
    for (const SurfacePoint& site : result.sites->points) {
        material.push_back(result.scene->mesh.material[site.face]);
    }
    const ThermalValues values =
        thermal_values(result, sum_of_parts(result.solution.irradiance, 1), material, field.points);
    field.point_arrays = {scalar("radius", "", result.sites->radius), scalar("area", "", result.sites->area)};
    for (const FieldArray& array : thermal_arrays(values)) {
        field.point_arrays.push_back({array.name, array.unit, {}, Values(*values_of(array))});
    }
    field.notes = notes_of(result);
    field.quality = "temperature";
}

} // namespace

FieldFile sites_of(const BakeResult& result) {
    FieldFile field;
    std::vector<std::int32_t> face, region;
    for (std::size_t i = 0; i < result.sites->size(); ++i) {
        const SurfacePoint& site = result.sites->points[i];
        field.points.push_back(site.position);
        field.normals.push_back(site.normal);
        face.push_back(static_cast<std::int32_t>(result.scene->mesh.original_face[site.face]));
        region.push_back(static_cast<std::int32_t>(result.sites->region[i]));
    }
    const int channels = result.channels;
    const auto count = static_cast<Eigen::Index>(result.sites->size());
    if (result.thermal) {
        add_thermal_sites(result, field);
        field.point_arrays.push_back(numbers("original_face_id", std::move(face)));
        field.point_arrays.push_back(numbers("region", std::move(region)));
        return field;
    }
    const Values H = three_channels(sum_of_parts(result.solution.irradiance, channels));
    Values rho(count, 3), E(count, 3);
    for (Eigen::Index i = 0; i < count; ++i) {
        const SurfacePoint& site = result.sites->points[static_cast<std::size_t>(i)];
        rho.row(i) = result.scene->reflectance(site).matrix().transpose();
        E.row(i) = result.scene->emission(site).matrix().transpose();
    }
    const Values B = E + rho.cwiseProduct(H);
    std::vector<std::uint8_t> display;
    const double exposure = display_exposure(result);
    for (const double value : B.reshaped<Eigen::RowMajor>()) {
        display.push_back(static_cast<std::uint8_t>(std::lround(255.0 * srgb(exposure * value))));
    }
    field.point_arrays = {
        scalar("radius", "", result.sites->radius),
        scalar("area", "", result.sites->area),
        colour("coefficient", flux, three_channels(sum_of_parts(result.field().parts().smooth, channels))),
        colour("irradiance", flux, H),
        colour("radiosity", flux, B),
        colour("reflectance", "", rho),
        colour("emission", flux, E),
        {"display_rgb", "", rgb, std::move(display)},
        numbers("original_face_id", std::move(face)),
        numbers("region", std::move(region))};
    add_scalars(result, B, H, field.point_arrays);
    field.notes = notes_of(result);
    field.notes.push_back({"display_exposure", std::vector<double>{exposure}});
    field.active_colours = "display_rgb";
    field.quality = result.photometric ? "luminance" : "radiosity_weighted";
    return field;
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

} // namespace

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

std::vector<std::filesystem::path> BakeFiles::beside_field() const {
    std::vector<std::filesystem::path> named;
    for (const std::filesystem::path& file : {sites, listed, report, error_chart, transport}) {
        if (!file.empty()) {
            named.push_back(file);
        }
    }
    return named;
}

void write_bake(const BakeResult& result, const BakeFiles& files, const Execution& execution) {
    execution.phase("write");
    std::vector<std::unique_ptr<WholeFile>> written;
    const auto write = [&](const std::filesystem::path& file, const auto& content) {
        if (!file.empty()) {
            written.push_back(std::make_unique<WholeFile>(file));
            content(*written.back());
            if (execution.progress != nullptr) {
                execution.progress->check();
            }
        }
    };
    write(files.field, [&](WholeFile& file) { write_finite_field(field_of(result), files.field, file, execution); });
    write(files.sites, [&](WholeFile& file) { write_finite_field(sites_of(result), files.sites, file, execution); });
    write(files.listed, [&](WholeFile& file) { file.write(point_table(result)); });
    write(files.transport, [&](WholeFile& file) { write_transport(saved_transport_of(result), file); });
    write(files.report, [&](WholeFile& file) { file.write(report_of(result)); });
    write(files.error_chart, [&](WholeFile& file) { file.write(error_chart_of(result)); });
    for (const std::unique_ptr<WholeFile>& file : written) {
        file->commit();
    }
}

namespace {

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
        text << "no useful bound from the residual, because the surfaces absorb little (largest reflectance "
             << error.largest_reflectance << "); more sites and rays would tighten it";
    } else {
        text << "no proven bound, since "
             << (thermal ? "the net flux of some surface is prescribed" : "some surface absorbs nothing");
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
    text << std::setprecision(4) << "grid on " << result.options.grids[number].on << ": " << grid.count << " sensors, "
         << (result.photometric ? "illuminance (lx)" : "irradiance (W/m^2)") << " minimum " << grid.least << ", mean "
         << grid.mean << ", maximum " << grid.most << ", uniformity (minimum / mean) " << std::setprecision(3)
         << grid.uniformity;
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

} // namespace

std::string summary_of(const BakeResult& result) {
    std::ostringstream text;
    text << result.file << ": " << counted(result.diagnosis.file_faces, "face") << ", "
         << counted(result.scene->mesh.triangles.size(), "triangle") << ", area " << result.scene->mesh.area << ", "
         << result.scene->mesh.region_count << (result.scene->mesh.region_count == 1 ? " region" : " regions") << "\n";
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
    if (result.dry_run) {
        const BakeEstimate& estimate = result.estimate;
        text << "rays: " << estimate.rays << ", visibility segments: at most " << estimate.segments << "\n"
             << "error estimate, first round" << (result.options.goals.empty() ? "" : ", goals")
             << (result.options.final_gather > 0 ? ", final gather: " : ": ") << estimate.further_rays << " rays\n"
             << "memory for transport: at most " << format_bytes(estimate.transport_bytes) << "\n"
             << predicted_time(estimate);
        return text.str();
    }
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
    text << "solve: " << result.solution.solve.sentence() << "\n";
    text << (result.thermal ? thermal_summary(result) : energy_sentence(result.solution.energy, result.photometric));
    double total = 0.0;
    for (const auto& [phase, took] : result.journal.seconds()) {
        total += took;
    }
    for (std::size_t i = 0; i < result.attempts.size(); ++i) {
        const Attempt& attempt = result.attempts[i];
        text << std::setprecision(2) << "attempt " << i + 1 << ": " << attempt.effort.sites << " sites, "
             << attempt.effort.rays << " rays, " << attempt.effort.error_points << " error points: about "
             << 100.0 * attempt.rms << " %, below " << 100.0 * attempt.high << " %";
        if (attempt.goals) {
            text << "; goals with " << attempt.effort.goal_samples << " samples each: within " << 100.0 * *attempt.goals
                 << " %";
        }
        text << " (" << format_seconds(attempt.seconds) << ")\n";
    }
    if (result.error) {
        text << error_sentence(*result.error, result.thermal.has_value()) << "\n";
    }
    for (std::size_t g = 0; g < result.options.grids.size(); ++g) {
        text << grid_sentence(result, g) << "\n";
    }
    for (const GoalEstimate& goal : result.goal_estimates) {
        text << goal_sentence(goal, result.photometric) << "\n";
    }
    text << "time: " << format_seconds(total) << "; peak memory " << format_bytes(static_cast<double>(peak_memory()))
         << "\n";
    return text.str();
}

} // namespace difusa
