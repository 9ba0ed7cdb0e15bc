// relight transport out: lights a surface whose transport was saved by bake_radiosity. Parses options, writes files.
#include "bake_arguments.h"
#include "relight_studies.h"
#include "run_bake.h"

#include <difusa/bake/lamp_powers.h>
#include <difusa/bake/relight.h>
#include <difusa/core/text.h>
#include <difusa/import/text_scanner.h>
#include <difusa/output/series_files.h>
#include <difusa/output/text_table.h>

#include <cmath>
#include <filesystem>
#include <iostream>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace relight {

using difusa::Rgb;
using difusa::UsageError;

const char* const examples =
    R"(Lights a surface anew, in other light or other colours, with a transport saved by bake_radiosity. Rays from the
sites are cast again only for --daylight and around objects that are moved. The result is the same, to the bit, as that
of a bake in the new light whose sites are at the same places: with --no-adaptive, or with light that these were graded
for.

Examples:
  bake_radiosity room.json day.vtp --save-transport room.difusa
      bakes, and saves the transport
  relight room.difusa night.vtp --scale sun=0 --scale sky=0.01 --emission lamp=40,36,30
      night: sun off, a hundredth of the sky, and a material that emits
  relight room.difusa red.vtp --reflectance wall=0.6,0.1,0.1
      another colour
  relight room.difusa evening.vtp --scale sun=0 --sun 0.9,0.3,0.1,400,250,120
      the sun elsewhere
  relight room.difusa day.pvd --scale sun=0 --sun-path 48.14,11.58,2026-06-21,30 --time-zone 2
      a day in Munich, every 30 minutes: open day.pvd in ParaView and press Play
  relight room.difusa moved.vtp --move chair=0.5,0,0 --save-transport moved.difusa
      a chair half a metre further: only rays that may meet it, before or after, are cast again
  relight room.difusa other.vtp --scene other.json
      the materials, textures and lights of another scene with the same surface
  relight room.difusa --daylight room.mtx --at desk.csv
      the irradiance of desks for each part of the sky, for Radiance's matrix tools
  relight --daylight-from room.mtx --daylight-sky perez:direct=700,diffuse=120,elevation=40 --daylight-output lux.csv
      what they receive under a sky, as a product
  relight room.difusa --gradients by.csv --goal goals.json
      how the means of goals depend on every emission and reflectance
  relight room.difusa even.vtp --at desk.csv --solve-lamps 500
      lamps that light the desks to 500 lux as evenly as they can
  relight room.difusa --operator-table operators.csv --operator low-rank:rank=64 --operator neumann:bounces=4
      all reflections as one product, as a program may use it: its error, time and memory

Exit codes: 0 done, 1 usage, 2 input, 3 not converged, 4 resources, 5 internal, 130 interrupted.
)";

struct Arguments {
    std::filesystem::path transport, scene;
    difusa::LightChange change;
    std::vector<difusa::ObjectMove> moves;
    difusa::BakeArguments bake;
    difusa::RunArguments run;
    std::optional<difusa::SunPath> path;
    std::optional<std::pair<double, double>> hours;
    std::optional<double> time_zone;
    std::optional<difusa::Vec3> north;
    std::optional<Rgb> strength;
    difusa::StudyArguments studies;
    bool verbose = false;
};

/// "NAME=VALUE"; the name may contain '='.
std::pair<std::string, std::string> split_at_sign(const std::string& option, const std::string& text,
                                                  const std::string& form) {
    const std::size_t sign = text.rfind('=');
    if (sign == std::string::npos || sign == 0) {
        throw UsageError(option + " " + text + ": takes " + form);
    }
    return {text.substr(0, sign), text.substr(sign + 1)};
}

std::pair<std::string, Rgb> parse_material(const std::string& option, const std::string& text) {
    const auto [name, value] = split_at_sign(option, text, "MATERIAL=R or MATERIAL=R,G,B");
    return {name, difusa::parse_rgb(option + " " + name, value)};
}

std::pair<std::string, double> parse_scale(const std::string& option, const std::string& text) {
    const auto [name, value] = split_at_sign(option, text, "GROUP=FACTOR");
    const auto numbers = difusa::parse_numbers(value).value_or(std::vector<double>());
    if (numbers.size() != 1 || numbers[0] < 0.0) {
        throw UsageError(option + " " + text + ": the factor must be a number of at least 0");
    }
    return {name, numbers[0]};
}

/// "NAME=DX,DY,DZ", "NAME=DX,DY,DZ,DEGREES", or "NAME=" and the 16 numbers of a matrix, row by row.
difusa::ObjectMove parse_move(const std::string& option, const std::string& text) {
    const std::string form = "OBJECT=DX,DY,DZ[,DEGREES], or OBJECT= and the 16 numbers of a matrix, row by row";
    const auto [name, value] = split_at_sign(option, text, form);
    const auto numbers = difusa::parse_numbers(value).value_or(std::vector<double>());
    difusa::ObjectMove move;
    move.object = name;
    if (numbers.size() == 3 || numbers.size() == 4) {
        move.motion.offset = {numbers[0], numbers[1], numbers[2]};
        move.turn = numbers.size() == 4 ? numbers[3] : 0.0;
        return move;
    }
    const bool is_matrix = numbers.size() == 16 && numbers[12] == 0.0 && numbers[13] == 0.0 && numbers[14] == 0.0;
    if (!is_matrix || numbers[15] != 1.0) {
        throw UsageError(option + " " + text + ": takes " + form + ", of which the last row is 0,0,0,1");
    }
    for (Eigen::Index row = 0; row < 3; ++row) {
        const double* const n = numbers.data() + 4 * row;
        move.motion.rotation.row(row) << n[0], n[1], n[2];
        move.motion.offset[row] = n[3];
    }
    if (!difusa::is_rigid(move.motion)) {
        throw UsageError(option + " " + text +
                         ": the matrix must be that of a rigid motion, which neither scales nor "
                         "mirrors");
    }
    return move;
}

/// "48.1,11.6,2026-06-21" or "48.1,11.6,2026-06-21,30".
difusa::SunPath parse_sun_path(const std::string& option, const std::string& text) {
    const auto refuse = [&]() -> difusa::SunPath {
        throw UsageError(option + " " + text +
                         ": takes LATITUDE,LONGITUDE,YEAR-MONTH-DAY[,MINUTES] with nothing but commas between, such as "
                         "48.14,11.58,2026-06-21,30");
    };
    std::vector<std::string> fields;
    std::istringstream stream(text);
    for (std::string field; std::getline(stream, field, ',');) {
        fields.push_back(field);
    }
    if (fields.size() < 3 || fields.size() > 4 || text.back() == ',') {
        return refuse();
    }
    const auto place = difusa::parse_numbers(fields[0] + "," + fields[1]);
    const auto minutes = difusa::parse_numbers(fields.size() == 4 ? fields[3] : "60");
    std::vector<int> date;
    std::istringstream days(fields[2]);
    for (std::string part; std::getline(days, part, '-');) {
        date.push_back(difusa::parse_whole<int>(option + " " + text + ": day", part, 1));
    }
    if (!place || place->size() != 2 || !minutes || minutes->size() != 1 || date.size() != 3) {
        return refuse();
    }
    difusa::SunPath path;
    path.latitude = (*place)[0];
    path.longitude = (*place)[1];
    path.date = {date[0], date[1], date[2]};
    path.step = (*minutes)[0] / 60.0;
    return path;
}

/// Numbers with nothing but commas between.
std::vector<double> parse_count(const std::string& option, const std::string& text, std::size_t count,
                                const char* form) {
    const auto numbers = difusa::parse_numbers(text);
    if (!numbers || numbers->size() != count) {
        throw UsageError(option + " " + text + ": takes " + form);
    }
    return *numbers;
}

void declare_path(CLI::App& app, Arguments& a) {
    const std::string group = "Sun over a day (writes a .pvd, and a .vtp for each time)";
    difusa::add_parsed(
        app, "--sun-path", a.path,
        "a sun beside the other lights, as it stands at a place (degrees north and east) on a day, every so many "
        "minutes (60), while it is above the horizon",
        parse_sun_path)
        ->group(group)
        ->type_name("LAT,LON,Y-M-D[,MIN]");
    difusa::add_parsed(app, "--hours", a.hours, "between these times only (default: 0,24)",
                       [](const std::string& option, const std::string& text) {
                           const std::vector<double> hours = parse_count(option, text, 2, "FROM,TO in hours");
                           return std::pair(hours[0], hours[1]);
                       })
        ->group(group)
        ->type_name("FROM,TO");
    difusa::add_parsed(app, "--time-zone", a.time_zone, "of all times, hours east of universal time (default: 0)",
                       [](const std::string& option, const std::string& text) {
                           return parse_count(option, text, 1, "a number of hours")[0];
                       })
        ->group(group)
        ->type_name("H");
    difusa::add_parsed(app, "--north", a.north, "direction of north in the scene (default: +y where z is up, else -z)",
                       difusa::parse_point)
        ->group(group)
        ->type_name("X,Y,Z");
    difusa::add_parsed(
        app, "--sun-strength", a.strength,
        "irradiance of a surface that faces the sun, W/m^2, at all times (default: under a clear sky, by the sun's "
        "elevation; where the scene's lights are photometric, of its light alone)",
        difusa::parse_rgb)
        ->group(group)
        ->type_name("R[,G,B]");
}

void declare_light(CLI::App& app, Arguments& a) {
    const std::string group = "Scene";
    app.add_option("--scene", a.scene,
                   "scene of the same surface, whose materials, textures and lights are to be used (default: the one "
                   "that was baked)")
        ->group(group)
        ->type_name("FILE");
    difusa::add_repeated(app, "--scale", a.change.scale,
                         "factor on a light group of the scene, or of the lights that the bake added: an emitting "
                         "material, sun, point light, sky; 0 turns it off (may be repeated)",
                         parse_scale)
        ->group(group)
        ->type_name("GROUP=FACTOR");
    difusa::add_repeated(app, "--emission", a.change.emission,
                         "radiosity that a material emits, W/m^2 (may be repeated)", parse_material)
        ->group(group)
        ->type_name("MATERIAL=R[,G,B]");
    difusa::add_repeated(app, "--reflectance", a.change.reflectance,
                         "reflectance of a material, a factor on its texture, if any (may be repeated)", parse_material)
        ->group(group)
        ->type_name("MATERIAL=R[,G,B]");
    difusa::add_repeated(app, "--move", a.moves,
                         "moves a mesh of the scene file or a material, by name, or faces by their numbers (12-40): by "
                         "a vector, in metres in a scene file, after a turn about the vertical through its middle, "
                         "counterclockwise seen from above; or by a 4 by 4 matrix. Only rays that may meet it, before "
                         "or after, are cast again (may be repeated)",
                         parse_move)
        ->group(group)
        ->type_name("OBJECT=DX,DY,DZ[,DEG]");
    add_lamp_arguments(app, a.bake.options);
    app.get_option("--sky")->description(
        "irradiance of an unshaded surface under a uniform sky, W/m^2, in place of the sky of the bake");
    for (const char* const added : {"--sun", "--point-light"}) {
        CLI::Option* const option = app.get_option(added);
        option->description("another " + option->get_description());
    }
}

void declare(CLI::App& app, Arguments& a) {
    app.add_option("transport", a.transport, "file written by bake_radiosity --save-transport")->type_name("TRANSPORT");
    declare_light(app, a);
    declare_path(app, a);
    declare_studies(app, a.studies);
    const std::string transport = "Light transport";
    difusa::BakeOptions& options = a.bake.options;
    app.add_option("--first-bounce", options.first_bounce,
                   "the first reflection of suns, point lights and area lights: live (where such light falls on a "
                   "small part of the surface, samples there supplement the rays; shadow rays) or operator (by the "
                   "saved rays alone: faster, and blotchy where few of them meet that part)")
        ->group(transport)
        ->type_name("NAME")
        ->capture_default_str();
    add_direct_arguments(app, options, transport);
    add_solver_arguments(app, options, transport);
    add_result_arguments(app, a.bake, "each output vertex");
    for (const char* const kept :
         {"--direct", "--shadow-rays", "--visibility", "--solver", "--stop", "--tolerance", "--max-iterations"}) {
        app.get_option(kept)->default_str("as in the bake");
    }
    add_mesh_output_arguments(app, a.bake);
    app.add_option("--save-transport", a.bake.files.transport,
                   "also write the transport of the surface as it is now, with what was moved, to be relit and moved "
                   "again; changes of light and colours are not part of it")
        ->group("Output")
        ->type_name("FILE");
    add_run_arguments(app, a.run, "the result does not depend");
    app.add_flag("--verbose", a.verbose, "also print choices, times and residuals")->group(difusa::run_group);
}

bool is_series(const std::filesystem::path& file) {
    return difusa::lower_case(file.extension().string()) == ".pvd";
}

void check_series(const Arguments& a) {
    const std::string out = a.bake.files.field.string();
    if (a.path.has_value() != is_series(a.bake.files.field)) {
        throw UsageError(a.path ? out + ": the output of --sun-path must end in .pvd (a series that ParaView plays)"
                                : out + ": a series needs --sun-path; for one lighting, write a .vtp, .ply or .glb");
    }
    const bool north_of_sky = a.north && !a.studies.daylight.empty();
    if (!a.path && (a.hours || a.time_zone || (a.north && !north_of_sky) || a.strength)) {
        throw UsageError("--hours, --time-zone, --north and --sun-strength say where the sun of --sun-path stands (and "
                         "--north where the parts of --daylight begin): give that, too");
    }
    if (a.path && (!a.bake.files.report.empty() || !a.bake.files.sites.empty() || !a.bake.goal.empty())) {
        throw UsageError("--report, --sites-output and --goal are of one lighting: omit them with --sun-path");
    }
}

/// The path with what further options say of it.
difusa::SunPath path_of(const Arguments& a) {
    difusa::SunPath path = *a.path;
    path.time_zone = a.time_zone.value_or(path.time_zone);
    path.from = a.hours ? a.hours->first : path.from;
    path.to = a.hours ? a.hours->second : path.to;
    path.north = a.north;
    path.strength = a.strength;
    return path;
}

/// The series and its members.
std::vector<std::filesystem::path> series_of(const Arguments& a) {
    std::vector<std::filesystem::path> files{a.bake.files.field};
    difusa::SunPath path = path_of(a);
    path.north.reset(); // when the sun shines does not depend on it
    const std::size_t count = sun_steps(path, difusa::Vec3::UnitZ()).size();
    for (std::size_t i = 0; i < count; ++i) {
        files.push_back(difusa::series_member(a.bake.files.field, i));
    }
    return files;
}

/// Throws UsageError if a name has two values.
template <class Value>
void check_once(const std::string& option, const std::vector<std::pair<std::string, Value>>& values) {
    for (std::size_t i = 0; i < values.size(); ++i) {
        for (std::size_t k = 0; k < i; ++k) {
            if (values[i].first == values[k].first) {
                throw UsageError(option + " " + values[i].first + ": given twice; give one value");
            }
        }
    }
}

void check_files(const Arguments& a) {
    if (!a.bake.files.transport.empty() && (a.path || a.studies.without_field())) {
        throw UsageError("--save-transport " + a.bake.files.transport.string() +
                         ": is written beside one lit field: omit it with --sun-path, --daylight and --gradients");
    }
    check_studies(a.studies, a.bake, a.path.has_value());
    if (!a.studies.daylight_from.empty()) {
        if (!a.transport.empty()) {
            throw UsageError("--daylight-from: the product needs no transport: omit " + a.transport.string());
        }
        check_outputs(outputs_of(a.studies), {{a.studies.daylight_from, "the coefficients"}});
        return;
    }
    if (a.transport.empty()) {
        throw UsageError("a saved transport is expected: relight room.difusa out.vtp (--help)");
    }
    if (a.bake.files.field.empty() && !a.studies.without_field()) {
        throw UsageError("an output file is expected: relight " + a.transport.string() + " out.vtp (--help)");
    }
    std::vector<std::pair<std::filesystem::path, std::string>> inputs{{a.transport, "the transport"}};
    if (!a.scene.empty()) {
        inputs.emplace_back(a.scene, "the scene");
    }
    check_series(a);
    difusa::BakeArguments bake = a.bake;
    std::vector<difusa::OutputName> outputs = outputs_of(a.studies);
    if (!bake.at.empty() && (a.studies.without_field() || a.studies.lamps) && bake.files.listed.empty()) {
        inputs.emplace_back(bake.at, "the list of points"); // which need no table of their own
        bake.at.clear();
        bake.options.sensor = "planar";
        bake.options.sensor_rays = 0;
        bake.options.snap = false;
    }
    if (a.path) {
        for (const std::filesystem::path& file : series_of(a)) {
            outputs.push_back({file, !is_series(file)});
        }
        bake.files.field.clear();
    }
    check_bake_outputs(bake, outputs, inputs);
}

/// "09:30".
std::string clock_time(double hours) {
    const long minutes = std::lround(60.0 * hours), whole = minutes / 60, rest = minutes % 60;
    return difusa::formatted("%02.0f", static_cast<double>(whole)) + ":" +
           difusa::formatted("%02.0f", static_cast<double>(rest));
}

void relight_series(const Arguments& a, const difusa::Registry& registry, difusa::RelightOptions& how) {
    const std::vector<std::filesystem::path> files = series_of(a);
    how.bake.outputs.insert(how.bake.outputs.end(), files.begin(), files.end());
    how.bake.error_points = how.bake.error_points.value_or(0);
    difusa::SeriesWriter writer(a.bake.files.field, a.bake.files.listed);
    std::vector<std::vector<std::string>> times{{"time", "azimuth of the sun", "elevation"}};
    run_bake({}, a.run, a.verbose, [&](const difusa::Execution& execution) {
        return difusa::with_transport(a.transport, a.bake, how, execution, [&](const difusa::SavedTransport& saved) {
            const auto write = [&](const difusa::SunStep& step, const difusa::BakeResult& result) {
                times.push_back({clock_time(step.hours), difusa::formatted("%.2f", step.position.azimuth),
                                 difusa::formatted("%.2f", step.position.elevation)});
                writer.add(step, result, execution);
            };
            difusa::BakeResult last = relight_sun_path(registry, saved, how, path_of(a), write, execution);
            writer.commit();
            return last;
        });
    });
    if (!a.run.quiet) {
        std::cout << "the above is of the first of these times (degrees; azimuth from north over east):\n"
                  << difusa::text_table(times);
        const std::size_t count = files.size() - 1;
        std::cout << "written: " << a.bake.files.field.string() << " (" << difusa::counted(count, "time")
                  << (count == 1 ? ", " : ", from ") << files[1].filename().string()
                  << (count == 1 ? "" : " to " + files.back().filename().string()) << ")\n";
        if (!a.bake.files.listed.empty()) {
            std::cout << "written: " << a.bake.files.listed.string() << "\n";
        }
    }
}

/// Daylight coefficients, gradients: of a solution that is not evaluated.
void run_without_field(const Arguments& a, const difusa::Registry& registry, difusa::RelightOptions& how) {
    how.evaluate = false;
    difusa::StudyArguments studies = a.studies;
    studies.request.north = a.north;
    for (const difusa::OutputName& output : outputs_of(studies)) {
        how.bake.outputs.push_back(output.file);
    }
    how.bake.light_groups = how.bake.light_groups || !studies.operator_table.empty();
    if (!studies.gradients.empty()) {
        how.bake.light_groups = true;
        how.bake.first_bounce = "operator";
    }
    run_studies(studies, a.run, [&](const difusa::Execution& execution) {
        return difusa::with_transport(a.transport, a.bake, how, execution, [&](const difusa::SavedTransport& saved) {
            return difusa::relight(registry, saved, how, execution);
        });
    });
}

void run(const Arguments& a) {
    const difusa::Registry registry = difusa::Registry::load(a.run.plugin_path);
    check_files(a);
    check_once("--scale", a.change.scale);
    check_once("--emission", a.change.emission);
    check_once("--reflectance", a.change.reflectance);
    difusa::RelightOptions how;
    how.change = a.change;
    how.moves = a.moves;
    how.bake = bake_options(a.bake, registry);
    if (!a.scene.empty()) {
        how.scene = a.scene;
    }
    if (a.studies.without_field()) {
        run_without_field(a, registry, how);
        return;
    }
    if (a.path) {
        relight_series(a, registry, how);
        return;
    }
    run_bake(a.bake.files, a.run, a.verbose, [&](const difusa::Execution& execution) {
        return difusa::with_transport(a.transport, a.bake, how, execution, [&](const difusa::SavedTransport& saved) {
            difusa::LampPowers powers;
            return a.studies.lamps ? relight_lamps(registry, saved, how, *a.studies.lamps, powers, execution)
                                   : difusa::relight(registry, saved, how, execution);
        });
    });
}

int program(int count, char** words) {
    Arguments arguments;
    CLI::App app(examples, "relight");
    declare(app, arguments);
    return difusa::run_command(app, count, words, "one transport and one output file", arguments.run.version,
                               [&] { run(arguments); });
}

} // namespace relight
