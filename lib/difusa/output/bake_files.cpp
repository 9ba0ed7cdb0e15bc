#include <difusa/output/bake_files.h>

#include <difusa/bake/saved_transport.h>
#include <difusa/bake/thermal.h>
#include <difusa/core/photometry.h>
#include <difusa/io/field_writers.h>
#include <difusa/output/error_chart.h>
#include <difusa/output/point_table.h>
#include <difusa/output/thermal_files.h>
#include <difusa/version.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
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
    number("shadow_rays", static_cast<double>(options.shadow_rays));
    number("error_points", static_cast<double>(options.error_points.value_or(0)));
    number("crease_angle", result.scene->mesh.crease_angle);
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
    field.up = result.up;

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
    field.up = result.up;
    field.notes = notes_of(result);
    field.notes.push_back({"display_exposure", std::vector<double>{exposure}});
    field.active_colours = "display_rgb";
    field.quality = result.photometric ? "luminance" : "radiosity_weighted";
    return field;
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

} // namespace difusa
