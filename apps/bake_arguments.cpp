#include "bake_arguments.h"

#include <difusa/bake/choices.h>
#include <difusa/bake/goals.h>
#include <difusa/import/text_scanner.h>
#include <difusa/output/point_list.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <sstream>
#include <vector>

namespace difusa {

namespace {

const char* const scene_group = "Scene";
const char* const output_group = "Output";

/// R or R,G,B at the end of a list of numbers that begins with three others.
Rgb light_of(const std::vector<double>& values) {
    return values.size() == 4 ? Rgb::Constant(values[3]) : Rgb(values[3], values[4], values[5]);
}

/// X,Y,Z,R or X,Y,Z,R,G,B with non-negative light; empty if the text is anything else.
std::vector<double> parse_light(const std::string& text) {
    std::vector<double> values = parse_numbers(text).value_or(std::vector<double>());
    const bool good =
        (values.size() == 4 || values.size() == 6) && *std::min_element(values.begin() + 3, values.end()) >= 0.0;
    return good ? values : std::vector<double>();
}

/// "0.3,0,1,1000" or "0.3,0,1,1000,950,900": a direction, and irradiances.
Sun parse_sun(const std::string& option, const std::string& text) {
    const std::vector<double> values = parse_light(text);
    if (values.empty() || !(std::hypot(values[0], values[1], values[2]) > 0.0)) {
        throw UsageError(option + " " + text + ": takes X,Y,Z,R or X,Y,Z,R,G,B with nothing but commas between: the " +
                         "direction towards the sun, and non-negative irradiances");
    }
    Sun sun;
    sun.towards = Vec3(values[0], values[1], values[2]).stableNormalized();
    sun.irradiance = light_of(values);
    return sun;
}

/// "1,0,2,50" or "1,0,2,50,45,40": a position, and intensities.
PointLight parse_point_light(const std::string& option, const std::string& text) {
    const std::vector<double> values = parse_light(text);
    if (values.empty()) {
        throw UsageError(option + " " + text + ": takes X,Y,Z,R or X,Y,Z,R,G,B with nothing but commas between: the " +
                         "position of the light, and non-negative intensities");
    }
    PointLight light;
    light.position = Vec3(values[0], values[1], values[2]);
    light.intensity = light_of(values);
    return light;
}

/// "floor:spacing=0.5,height=0.8,margin=0.5"; the name may contain colons.
SensorGrid parse_grid(const std::string& option, const std::string& text) {
    const std::size_t colon = text.rfind(':');
    if (colon == std::string::npos || colon == 0) {
        throw UsageError(option + " " + text + ": takes FACE:spacing=D,height=H,margin=M, such as floor:spacing=0.5");
    }
    SensorGrid grid{text.substr(0, colon)};
    std::istringstream settings(text.substr(colon + 1));
    std::set<std::string> given;
    for (std::string setting; std::getline(settings, setting, ',');) {
        const std::size_t sign = std::min(setting.find('='), setting.size());
        const std::string name = setting.substr(0, sign), value = setting.substr(std::min(sign + 1, setting.size()));
        double* const target = name == "spacing"  ? &grid.spacing
                               : name == "height" ? &grid.height
                               : name == "margin" ? &grid.margin
                                                  : nullptr;
        const std::vector<double> numbers = parse_numbers(value).value_or(std::vector<double>());
        if (target == nullptr || numbers.size() != 1 || numbers[0] < 0.0) {
            throw UsageError(option + " " + text + ": `" + setting +
                             "` is none of spacing=D, height=H and margin=M with a length of at least 0");
        }
        if (!given.insert(name).second) {
            throw UsageError(option + " " + text + ": has two values of " + name);
        }
        *target = numbers[0];
    }
    if (!(grid.spacing > 0.0)) {
        throw UsageError(option + " " + text + ": needs a spacing above 0, such as " + grid.on + ":spacing=0.5");
    }
    return grid;
}

/// An option for the name of a plugin or method.
CLI::Option* add_name(CLI::App& app, const std::string& name, std::string& target, const std::string& what,
                      const std::string& group) {
    CLI::Option* option = app.add_option(name, target, what)->group(group)->type_name("NAME");
    return target.empty() ? option : option->capture_default_str();
}

void add_scene_arguments(CLI::App& app, BakeOptions& options) {
    add_parsed(app, "--reflectance", options.reflectance, "reflectance of faces without a colour, 0 to 1 (default 0.5)",
               parse_rgb)
        ->group(scene_group)
        ->type_name("R[,G,B]");
    add_lamp_arguments(app, options);
    add_name(app, "--flip", options.flip,
             "faces to turn over, so that their backs become fronts: auto (parts that are certainly inside out, as "
             "light meets only their backs; doubtful ones are noted), all, none",
             scene_group);
}

void add_target_arguments(CLI::App& app, BakeArguments& arguments) {
    const std::string group = "Accuracy";
    add_parsed(app, "--error", arguments.error,
               "accuracy to reach: adds sites, rays and shadow rays until the estimated rms error, relative to the "
               "reflected light, is below this with a confidence of 97.5 %; with --goal, until the half width of each "
               "goal's 95 % interval is; exit code 3 if it is out of reach",
               parse_percent)
        ->group(group)
        ->type_name("P%");
    add_whole<std::size_t>(app, "--max-sites", arguments.target.most_sites, 100,
                           "most sites, met to about 5 %, with --error")
        ->group(group)
        ->type_name("N")
        ->default_str(shown(arguments.target.most_sites));
    add_parsed(app, "--max-seconds", arguments.target.most_seconds,
               "start no attempt that will probably end later, with --error: the result then depends on the machine",
               parse_positive)
        ->group(group)
        ->type_name("S");
    app.add_flag("--best-effort", arguments.target.best_effort,
                 "if the accuracy of --error is out of reach, write the best result all the same; still exit code 3")
        ->group(group);
    app.add_option("--error-chart", arguments.files.error_chart,
                   "write a chart of the errors of all attempts of --error against time")
        ->group(group)
        ->type_name("FILE.svg");
}

/// Throws UsageError for options that contradict --error or do nothing without it.
void check_target(const CLI::App& app, bool ordered) {
    for (const char* const name : {"--max-sites", "--max-seconds", "--best-effort", "--error-chart"}) {
        if (!ordered && app.count(name) > 0) {
            throw UsageError(std::string(name) + ": has no effect without --error; ask for an accuracy, --error 1%");
        }
    }
    for (const char* const name : {"--quality", "--sites", "--spacing", "--adaptive", "--rays", "--error-points",
                                   "--goal-samples", "--final-gather"}) {
        if (ordered && app.count(name) > 0) {
            const bool negated = app.get_option(name)->results().back() == "false";
            throw UsageError((negated ? "--no-" + std::string(name).substr(2) : std::string(name)) +
                             ": cannot be combined with --error, which chooses the effort; omit "
                             "one of them");
        }
    }
}

/// What --quality chooses.
struct Preset {
    const char* name;
    std::size_t sites, rays;
    const char* projection; ///< empty: the default
    std::size_t final_gather;
    double output_in_spacings;
};
constexpr std::array<Preset, 3> presets{{
    {"draft", 1000, 128, "natural", 0, 1.0},
    {"normal", default_sites, 512, "", 0, 1.0},
    {"final", 20000, 1024, "galerkin", 256, 0.5},
}};
const char* const quality_help =
    "draft (1000 sites, 128 rays, natural projection: about a tenth of the time), normal (5000 sites, 512 rays: the "
    "default), final (20000 sites, 1024 rays, galerkin projection, final gather with 256 rays, output at half the "
    "spacing: about sixty times the time); options that are given take precedence";

/// Chooses what the command line does not.
void apply_quality(const BakeArguments& arguments, BakeOptions& options) {
    if (options.quality.empty()) {
        return;
    }
    const auto preset = std::find_if(presets.begin(), presets.end(),
                                     [&](const Preset& known) { return options.quality == known.name; });
    if (preset == presets.end()) {
        throw UsageError("--quality " + options.quality + ": must be draft, normal or final");
    }
    const auto& given = arguments.given;
    if (!given("--sites") && !given("--spacing")) {
        options.sites = preset->sites;
    }
    if (!given("--rays")) {
        options.rays = preset->rays;
    }
    if (!given("--projection") && options.transport.rfind("pairwise", 0) != 0) { // which has its own needs
        options.projection = preset->projection;
    }
    if (!given("--final-gather")) {
        options.final_gather = preset->final_gather;
    }
    options.output_in_spacings = preset->output_in_spacings;
}

void add_place_arguments(CLI::App& app, BakeArguments& arguments, const std::string& group) {
    BakeOptions& options = arguments.options;
    app.add_option("--at", arguments.at,
                   "table of places at which to report the light, with --at-output: x,y,z (the nearest point of the "
                   "surface) or x,y,z,nx,ny,nz (a sensor with this normal, where it stands) per line; in metres for a "
                   "scene file")
        ->group(group)
        ->type_name("FILE");
    add_name(app, "--sensor", options.sensor,
             "what is measured where the sensors stand: planar (irradiance by the normal), horizontal, spherical, "
             "cylindrical (mean irradiance of a small sphere, or of an upright cylinder)",
             group);
    add_whole<std::size_t>(
        app, "--sensor-rays", options.sensor_rays, 4,
        "rays from each sensor (default: 4096, and up to 65536 where their noise is above 2 % or they are few)")
        ->group(group)
        ->type_name("N");
    app.add_flag("--snap", options.snap, "places with a normal, too, are moved to the nearest surface that faces it")
        ->group(group);
    add_repeated(app, "--grid", options.grids,
                 "grid of sensors over a flat face, given by its number in the file or the name of its material; "
                 "minimum, mean, maximum and uniformity are reported (may be repeated)",
                 parse_grid)
        ->group(group)
        ->type_name("FACE:spacing=D,height=H,margin=M");
    app.add_option("--at-output", arguments.files.listed,
                   "write the light at the places of --at and --grid, comma-separated")
        ->group(group)
        ->type_name("FILE.csv");
}

} // namespace

void add_lamp_arguments(CLI::App& app, BakeOptions& options) {
    add_parsed(
        app, "--sky", options.sky,
        "irradiance of an unshaded surface under a uniform sky, W/m^2 (default: 1 if there is no other light, else 0)",
        parse_rgb)
        ->group(scene_group)
        ->type_name("R[,G,B]");
    add_repeated(app, "--sun", options.suns,
                 "sun: direction towards it, and the irradiance in W/m^2 of a surface that faces it (may be repeated)",
                 parse_sun)
        ->group(scene_group)
        ->type_name("X,Y,Z,R[,G,B]");
    add_repeated(
        app, "--point-light", options.point_lights,
        "point light: its position (in metres for a scene file), and its radiant intensity in W/sr (may be repeated)",
        parse_point_light)
        ->group(scene_group)
        ->type_name("X,Y,Z,R[,G,B]");
    app.add_flag("--light-groups", options.light_groups,
                 "write each light's contribution (emitting material, sun, point light, sky): arrays radiosity_of_NAME "
                 "and irradiance_of_NAME (in a .vtp, and in the table of --at)")
        ->group(scene_group);
}

void add_light_arguments(CLI::App& app, BakeOptions& options, const std::string& group) {
    add_direct_arguments(app, options, group);
    add_name(
        app, "--analytic", options.analytic,
        "exact form factors of surfaces that are fully visible from a point, in place of rays: auto (if they pay), "
        "always, never",
        group);
    add_name(app, "--kernel", options.kernel, "form factor of pairwise transport: disc (default) or point", group);
}

void add_direct_arguments(CLI::App& app, BakeOptions& options, const std::string& group) {
    add_name(
        app, "--direct", options.direct,
        "light from suns, point lights and area lights: exact (evaluated at each point, outside the linear system) "
        "or interpolated (represented in the basis, as in the dissertation)",
        group);
    add_name(app, "--visibility", options.visibility,
             "ray casting: embree (fast) or cgal (the reference); auto: embree if available, otherwise cgal", group);
}

void add_mirror_arguments(CLI::App& app, BakeOptions& options, const std::string& group) {
    add_whole<std::size_t>(app, "--mirror-depth", options.mirror_depth, 1,
                           "follow light over at most this many mirrors in a row")
        ->group(group)
        ->type_name("N")
        ->default_str(shown(options.mirror_depth));
}

void add_gloss_arguments(CLI::App& app, BakeOptions& options, const std::string& group) {
    add_whole<int>(
        app, "--directional-order", options.directional_order, 0,
        "order N of the spherical harmonics in which glossy materials send out light: (N + 1)^2 coefficients "
        "for each of their sites")
        ->group(group)
        ->type_name("N")
        ->default_str(shown(options.directional_order));
    app.add_flag_callback(
           "--no-gloss", [&options] { options.gloss = false; },
           "glossy materials absorb what they would reflect in a lobe")
        ->group(group);
}

void add_solver_arguments(CLI::App& app, BakeOptions& options, const std::string& group) {
    add_name(app, "--solver", options.solver, "krylov, jacobi, gauss-seidel:relaxation=1.1, southwell, progressive",
             group);
    add_parsed(app, "--tolerance", options.solve.tolerance,
               "largest residual, relative to the light before any reflection (or change: --stop)", parse_positive)
        ->group(group)
        ->type_name("T")
        ->default_str(shown(options.solve.tolerance));
    add_name(app, "--stop", options.stop,
             "what the tolerance limits: residual (the largest that is left) or change (the largest in an iteration)",
             group);
    add_whole(app, "--max-iterations", options.solve.max_iterations, 0, "give up after this many")
        ->group(group)
        ->type_name("N")
        ->default_str(shown(options.solve.max_iterations));
}

void add_bake_arguments(CLI::App& app, BakeArguments& arguments, const std::string& gathered) {
    BakeOptions& options = arguments.options;
    const std::string discretisation = "Discretisation";
    app.add_option("--quality", options.quality, quality_help)->group(discretisation)->type_name("NAME");
    add_site_arguments(app, options, discretisation);
    app.add_flag(
           "--adaptive,!--no-adaptive", options.adaptive,
           "place the sites where they help: the same number, denser where two short pilot bakes find that the light "
           "varies; the default, except with --spacing, for drafts and fewer than 400 sites, for transports that are "
           "saved, and for bases or samplers with sites of their own; with --basis patch-constant, elements into which "
           "patches are divided there")
        ->group(discretisation);
    add_parsed(app, "--levels", options.levels,
               "how often --adaptive may quarter a patch of --basis patch-constant, each part again (default: " +
                   std::to_string(default_levels) + ")",
               [](const std::string& option, const std::string& text) { return parse_whole<int>(option, text, 1); })
        ->group(discretisation)
        ->type_name("N");
    add_name(app, "--projection", options.projection,
             "how coefficients are computed from the light: natural (values at the sites, or a solve if the basis "
             "needs it), corrected:sweeps=2,in=field (residual added back; in=equation: also in the equation), "
             "interpolation, least-squares:points=3, galerkin:points=3, substructured (parts of patches send the mean "
             "of the patch; default: corrected, or natural if there is no residual, or if patches are divided, "
             "substructured)",
             discretisation);

    const std::string transport = "Light transport";
    add_name(app, "--transport", options.transport, "gather (rays from sites) or pairwise (form factors)", transport);
    add_whole<std::size_t>(app, "--rays", options.rays, 1, "rays from each site")
        ->group(transport)
        ->type_name("N")
        ->default_str(shown(options.rays));
    add_name(app, "--directions", options.directions, "set of ray directions", transport);
    add_light_arguments(app, options, transport);
    add_mirror_arguments(app, options, transport);
    add_gloss_arguments(app, options, transport);
    add_solver_arguments(app, options, transport);

    add_scene_arguments(app, options);
    add_target_arguments(app, arguments);
    add_result_arguments(app, arguments, gathered);
    app.final_callback([&app, &arguments] { check_target(app, arguments.error.has_value()); });
}

void add_result_arguments(CLI::App& app, BakeArguments& arguments, const std::string& gathered) {
    BakeOptions& options = arguments.options;
    arguments.given = [&app](const std::string& name) {
        const CLI::Option* option = app.get_option_no_throw(name);
        return option != nullptr && option->count() > 0;
    };
    const std::string output = output_group;
    add_whole<std::size_t>(
        app, "--final-gather", options.final_gather, 1,
        "gather the light at " + gathered +
            " with this many rays (rounded up to an even number), instead of evaluating the basis: "
            "slower, and far more accurate unless few rays meet what is bright, whose noise is stated")
        ->group(output)
        ->type_name("N");
    add_whole<std::size_t>(
        app, "--shadow-rays", options.shadow_rays, least_shadow_rays,
        "shadow rays from each point to the area lights that are behind too much for an exact view of them; half as "
        "many to each sun with a disc and each luminaire with an opening; after as many pilots, which do not count, "
        "and up to 15 times as many in penumbras")
        ->group(output)
        ->type_name("N")
        ->default_str(shown(options.shadow_rays));
    add_parsed(
        app, "--error-points", options.error_points,
        "surface points at which the error is estimated, about (default: an eighth of the sites, 400 to 4096; 0: no "
        "estimate); where ray noise prevails, fewer with more rays each",
        [](const std::string& option, const std::string& text) { return parse_whole<std::size_t>(option, text, 0); })
        ->group(output)
        ->type_name("N");
    app.add_option("--goal", arguments.goal,
                   "JSON file of goals: faces, materials or places whose mean irradiance is estimated by itself, "
                   "corrected by the adjoint, with its interval")
        ->group(output)
        ->type_name("FILE.json");
    add_whole<std::size_t>(app, "--goal-samples", options.goal_samples, 32, "surface points that judge each goal")
        ->group(output)
        ->type_name("N")
        ->default_str(shown(options.goal_samples));
    app.add_option("--sites-output", arguments.files.sites, "write the sites as points, .vtp, .ply or .glb")
        ->group(output)
        ->type_name("FILE");
    add_name(app, "--units", options.units,
             "of what is derived from the light: radiometric (W/m^2), photometric (lux and cd/m^2, 683 lm/W times "
             "0.2126 R + 0.7152 G + 0.0722 B), or auto: photometric if the scene file measures its lights so",
             output);
    add_place_arguments(app, arguments, output);
    app.add_option("--report", arguments.files.report, "write a report as JSON")->group(output)->type_name("FILE.json");
}

void require_target(const BakeResult& result) {
    if (result.target_missed) {
        throw NotConverged("the accuracy that --error asks for was not reached; the files hold the best result");
    }
}

void add_mesh_output_arguments(CLI::App& app, BakeArguments& arguments) {
    app.add_option(
           "out", arguments.files.field,
           "baked field: .vtp (everything), .ply (colours, and the radiosity or luminance) or .glb (glTF: colours, "
           "and all values at vertices)")
        ->type_name("OUT");
    add_parsed(app, "--output-spacing", arguments.options.output_spacing,
               "longest edge of the output mesh (default: the site spacing)", parse_positive)
        ->group(output_group)
        ->type_name("D");
    app.add_flag("--face-centres", arguments.options.face_centres,
                 "also write the light at the centres of the output's triangles, as cell arrays (in a .vtp)")
        ->group(output_group);
}

void grade_by_default(const BakeArguments& arguments, const Registry& registry, BakeOptions& options) {
    // Pilots with a quarter of them would tell little.
    constexpr std::size_t few = 400;
    const bool open = !arguments.given("--adaptive") && !arguments.given("--spacing") && !options.target &&
                      !options.every_surface && options.quality != presets.front().name;
    if (open && (options.sites == 0 || options.sites >= few)) {
        options.adaptive = can_be_graded(registry, options);
    }
}

BakeOptions bake_options(const BakeArguments& arguments, const Registry& registry) {
    BakeOptions options = arguments.options;
    if (arguments.given("--rays")) {
        check_rays(options.rays, options.directions, *registry.create<Directions>(options.directions));
    }
    apply_quality(arguments, options);
    const BakeFiles& files = arguments.files;
    options.outputs = files.beside_field();
    options.outputs.push_back(files.field);
    if (!arguments.at.empty()) {
        options.at = read_point_list(arguments.at);
    }
    if (arguments.error) {
        options.target = arguments.target;
        options.target->relative = *arguments.error;
    }
    if (!arguments.goal.empty()) {
        options.goals = read_goals(arguments.goal);
    } else if (options.goal_samples != BakeOptions().goal_samples) {
        throw UsageError("--goal-samples: there are no goals; name a file of goals, --goal FILE.json");
    }
    return options;
}

void check_bake_outputs(const BakeArguments& arguments, std::vector<OutputName> outputs,
                        std::vector<std::pair<std::filesystem::path, std::string>> inputs) {
    const bool places = !arguments.at.empty() || !arguments.options.grids.empty();
    if (!arguments.files.listed.empty() && !places) {
        throw UsageError("--at-output " + arguments.files.listed.string() +
                         ": no points were given; name a file of points, --at FILE, or a --grid");
    }
    if (!arguments.at.empty() && arguments.files.listed.empty()) {
        throw UsageError("--at " + arguments.at.string() + ": the results need an output file, --at-output FILE.csv");
    }
    if (arguments.options.sensor != "planar" && !places) {
        throw UsageError("--sensor " + arguments.options.sensor + ": there are no sensors; give --at or --grid");
    }
    if (arguments.options.sensor_rays > 0 && !places) {
        throw UsageError("--sensor-rays: there are no sensors; give --at or --grid");
    }
    if (const std::filesystem::path& chart = arguments.files.error_chart;
        !chart.empty() && lower_case(chart.extension().string()) != ".svg") {
        throw UsageError("--error-chart " + chart.string() + ": a chart is written as .svg");
    }
    if (arguments.options.snap && arguments.at.empty()) {
        throw UsageError("--snap: there are no places to move to the surface; give --at");
    }
    const std::string field = arguments.files.field.string();
    if (const std::string extension = lower_case(arguments.files.field.extension().string());
        extension == ".ply" || extension == ".glb") {
        if (extension == ".ply" && arguments.options.light_groups && arguments.at.empty()) {
            throw UsageError("--light-groups: a .ply cannot hold the light of each group; write " + field +
                             " as a .vtp or .glb, which can, or name points, --at FILE");
        }
        if (arguments.options.face_centres) {
            throw UsageError("--face-centres: a " + extension +
                             " cannot hold the light at the centres of faces; write " + field +
                             " as a .vtp, which can");
        }
    }
    if (!arguments.files.field.empty()) {
        outputs.insert(outputs.begin(), {arguments.files.field, true});
    }
    outputs.push_back({arguments.files.sites, true});
    outputs.push_back({arguments.files.report, false});
    outputs.push_back({arguments.files.listed, false});
    outputs.push_back({arguments.files.transport, false});
    outputs.push_back({arguments.files.error_chart, false});
    if (!arguments.at.empty()) {
        inputs.emplace_back(arguments.at, "the list of points");
    }
    if (!arguments.goal.empty()) {
        inputs.emplace_back(arguments.goal, "the file of goals");
    }
    check_outputs(outputs, inputs);
}

} // namespace difusa
