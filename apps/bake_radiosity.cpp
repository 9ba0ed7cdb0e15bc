// bake_radiosity mesh out: bakes diffuse global illumination onto a mesh. Options in, bake, files out.
#include "arguments.h"
#include "terminal.h"

#include <difusa/bake.h>
#include <difusa/io/bake_files.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <string>
#include <thread>
#include <vector>

namespace {

using difusa::add_parsed;
using difusa::add_whole;
using difusa::ExitCode;
using difusa::parse_positive;
using difusa::Rgb;
using difusa::shown;
using difusa::UsageError;

const char* const examples =
    R"(Bakes diffuse global illumination (radiosity) onto a mesh.

Examples:
  bake_radiosity mesh.off out.vtp
      bake with defaults; open out.vtp in ParaView and colour by radiosity or display_rgb
  bake_radiosity room.obj out.ply --rays 2048 --sites 10000
      a finer bake for MeshLab; the lamps are the materials with Ke
  bake_radiosity room.obj out.vtp --basis shepard:k=3 --spacing 0.05 --report out.json --sites-output sites.vtp
      another basis, a given distance between sites, a report, and the sites as points
  bake_radiosity hall.ply out.vtp --sky 1,1.1,1.3 --reflectance 0.7 --visibility embree
      sky light on a mesh without colours, fast rays
  bake_radiosity room.obj out.vtp --dry-run
      how many sites and rays, how much memory and time
  bake_radiosity --list-plugins

Exit codes: 0 done, 1 usage, 2 input, 3 not converged, 4 resources, 5 internal, 130 interrupted.
)";

struct Arguments {
    std::filesystem::path mesh;
    difusa::BakeFiles files;
    std::vector<std::filesystem::path> plugin_path;
    difusa::BakeOptions bake;
    unsigned threads = std::max(1U, std::thread::hardware_concurrency());
    const CLI::Option* kernel = nullptr;
    bool list_plugins = false, dry_run = false, quiet = false, verbose = false, version = false;
};

/// "0.5" or "0.5,0.4,0.3": finite numbers, none negative.
Rgb parse_rgb(const std::string& option, const std::string& text) {
    const std::vector<double> values = difusa::parse_numbers(text).value_or(std::vector<double>());
    const bool negative = std::any_of(values.begin(), values.end(), [](double v) { return v < 0.0; });
    if ((values.size() != 1 && values.size() != 3) || negative) {
        throw UsageError(option + " " + text + ": takes one number, or three R,G,B with nothing but commas between; " +
                         "none may be negative");
    }
    return values.size() == 1 ? Rgb::Constant(values[0]) : Rgb(values[0], values[1], values[2]);
}

/// "0.3,0,1,1000" or "0.3,0,1,1000,950,900": a direction, and irradiances that are not negative.
difusa::Sun parse_sun(const std::string& option, const std::string& text) {
    const std::vector<double> values = difusa::parse_numbers(text).value_or(std::vector<double>());
    const bool good = (values.size() == 4 || values.size() == 6) && std::hypot(values[0], values[1], values[2]) > 0.0 &&
                      *std::min_element(values.begin() + 3, values.end()) >= 0.0;
    if (!good) {
        throw UsageError(option + " " + text + ": takes X,Y,Z,R or X,Y,Z,R,G,B with nothing but commas between: the " +
                         "direction towards the sun, and irradiances that are not negative");
    }
    difusa::Sun sun;
    sun.towards = difusa::Vec3(values[0], values[1], values[2]).stableNormalized();
    sun.irradiance = values.size() == 4 ? Rgb::Constant(values[3]) : Rgb(values[3], values[4], values[5]);
    return sun;
}

void declare(CLI::App& app, Arguments& a) {
    app.add_option("mesh", a.mesh, "mesh or scene: .off .obj .ply .stl .gltf .glb .json")->type_name("MESH");
    app.add_option("out", a.files.field, "baked field: .vtp (everything) or .ply (colours and luminance)")
        ->type_name("OUT");

    const std::string discretisation = "Discretisation";
    app.add_option("--basis", a.bake.basis, "finite elements")
        ->group(discretisation)
        ->type_name("NAME")
        ->capture_default_str();
    app.add_option("--sampler", a.bake.sampler, "where the sites go")
        ->group(discretisation)
        ->type_name("NAME")
        ->capture_default_str();
    app.add_option("--projection", a.bake.projection,
                   "coefficients: natural (as the basis says), interpolation, corrected:sweeps=2, "
                   "least-squares:points=3, galerkin:points=3")
        ->group(discretisation)
        ->type_name("NAME")
        ->capture_default_str();
    add_parsed(app, "--spacing", a.bake.spacing, "least distance between sites, in units of the mesh", parse_positive)
        ->group(discretisation)
        ->type_name("D");
    add_whole<std::size_t>(app, "--sites", a.bake.sites, 1,
                           "wanted number of sites, instead of --spacing (default 4000)")
        ->group(discretisation)
        ->type_name("N");
    add_whole(app, "--neighbours", a.bake.neighbours, 1, "a site's radius reaches to its M-th nearest site")
        ->group(discretisation)
        ->type_name("M")
        ->default_str(shown(a.bake.neighbours));

    const std::string transport = "Light transport";
    app.add_option("--transport", a.bake.transport, "gather (rays from sites) or pairwise (form factors)")
        ->group(transport)
        ->type_name("NAME")
        ->capture_default_str();
    add_whole<std::size_t>(app, "--rays", a.bake.rays, 1, "rays from each site; powers of two are best")
        ->group(transport)
        ->type_name("N")
        ->default_str(shown(a.bake.rays));
    app.add_option("--direct", a.bake.direct,
                   "light of suns and lamps: exact (computed at the very point) or interpolated between sites (as in "
                   "the dissertation)")
        ->group(transport)
        ->type_name("NAME")
        ->capture_default_str();
    app.add_option("--first-bounce", a.bake.first_bounce,
                   "light of suns and lamps after one reflection: gathered where rays hit (default; sharp), or "
                   "interpolated between sites (half the rays; the way of pairwise)")
        ->group(transport)
        ->type_name("NAME");
    app.add_option("--directions", a.bake.directions, "directions of the rays")
        ->group(transport)
        ->type_name("NAME")
        ->capture_default_str();
    a.kernel = app.add_option("--kernel", a.bake.kernel, "form factor of pairwise transport: disc or point")
                   ->group(transport)
                   ->type_name("NAME")
                   ->capture_default_str();
    app.add_option("--visibility", a.bake.visibility, "ray casting: cgal (reference) or embree (fast)")
        ->group(transport)
        ->type_name("NAME")
        ->capture_default_str();
    app.add_option("--solver", a.bake.solver, "krylov or jacobi")
        ->group(transport)
        ->type_name("NAME")
        ->capture_default_str();
    add_parsed(app, "--tolerance", a.bake.solve.tolerance,
               "largest residual, relative to the light that is not reflected yet", parse_positive)
        ->group(transport)
        ->type_name("T")
        ->default_str(shown(a.bake.solve.tolerance));
    add_whole(app, "--max-iterations", a.bake.solve.max_iterations, 0, "give up after so many")
        ->group(transport)
        ->type_name("N")
        ->default_str(shown(a.bake.solve.max_iterations));

    const std::string light = "Scene";
    add_parsed(app, "--reflectance", a.bake.reflectance, "of faces without a colour, 0 to 1 (default 0.5)", parse_rgb)
        ->group(light)
        ->type_name("R[,G,B]");
    add_parsed(
        app, "--sky", a.bake.sky,
        "irradiance a uniform sky gives an unshaded surface, W/m^2 (default: 1 if there is no other light, else 0)",
        parse_rgb)
        ->group(light)
        ->type_name("R[,G,B]");

    app.add_option_function<std::vector<std::string>>(
           "--sun",
           [&a](const std::vector<std::string>& texts) {
               for (const std::string& text : texts) {
                   a.bake.suns.push_back(parse_sun("--sun", text));
               }
           },
           "sun: direction towards it, and the irradiance in W/m^2 of a surface that faces it (may be repeated)")
        ->group(light)
        ->type_name("X,Y,Z,R[,G,B]")
        ->expected(-1)
        ->allow_extra_args(false); // one sun each time

    const std::string output = "Output";
    add_parsed(app, "--output-spacing", a.bake.output_spacing,
               "longest edge of the output mesh (default: the site spacing)", parse_positive)
        ->group(output)
        ->type_name("D");
    add_whole<std::size_t>(
        app, "--final-gather", a.bake.final_gather, 1,
        "gather the light at each output vertex with so many rays (an even number), instead of evaluating the basis: "
        "slower, and far more accurate")
        ->group(output)
        ->type_name("N");
    add_parsed(
        app, "--error-points", a.bake.error_points,
        "surface points at which the error is estimated (default: an eighth of the sites, 128 to 4096; 0: no estimate)",
        [](const std::string& option, const std::string& text) {
            return difusa::parse_whole<std::size_t>(option, text, 0);
        })
        ->group(output)
        ->type_name("N");
    app.add_option("--sites-output", a.files.sites, "write the sites as points, .vtp or .ply")
        ->group(output)
        ->type_name("FILE");
    app.add_option("--report", a.files.report, "write a report as JSON")->group(output)->type_name("FILE.json");

    const std::string run = "Running";
    add_whole<std::uint64_t>(app, "--seed", a.bake.seed, 0, "of all random choices")
        ->group(run)
        ->type_name("N")
        ->default_str(shown(a.bake.seed));
    add_whole(app, "--threads", a.threads, 1U, "threads; the result does not depend on it")
        ->group(run)
        ->type_name("N")
        ->default_str(shown(a.threads));
    app.add_option("--plugin-path", a.plugin_path, "another directory with plugins (may be repeated)")
        ->group(run)
        ->type_name("DIR")
        ->expected(-1)
        ->allow_extra_args(false); // one directory each time
    app.add_flag("--dry-run", a.dry_run, "say what the bake would take, and stop; writes no more than --report")
        ->group(run);
    app.add_flag("--quiet", a.quiet, "only errors")->group(run);
    app.add_flag("--verbose", a.verbose, "also choices, times and residuals")->group(run);
    app.add_flag("--list-plugins", a.list_plugins, "all plugins with their parameters, refused ones included")
        ->group(run);
    app.add_flag("--version", a.version, "version, and those of the libraries")->group(run);
}

void list_plugins(const difusa::Registry& registry) {
    std::string kind;
    std::vector<const difusa::LoadedPlugin*> sorted;
    for (const difusa::LoadedPlugin& plugin : registry.plugins()) {
        sorted.push_back(&plugin);
    }
    std::sort(sorted.begin(), sorted.end(), [](const auto* a, const auto* b) {
        return std::pair(a->description.kind, a->description.name) <
               std::pair(b->description.kind, b->description.name);
    });
    for (const difusa::LoadedPlugin* plugin : sorted) {
        const difusa::PluginDescription& description = plugin->description;
        if (description.kind != kind) {
            kind = description.kind;
            std::cout << kind << "\n";
        }
        std::cout << "  " << description.name << "  " << description.summary << "\n";
        for (const difusa::ParameterSpec& parameter : description.parameters) {
            std::cout << "      " << parameter.name << "="
                      << (parameter.default_value.empty() ? "(none)" : parameter.default_value) << "  "
                      << parameter.meaning;
            for (std::size_t i = 0; i < parameter.words.size(); ++i) {
                std::cout << (i == 0 ? ": " : ", ") << parameter.words[i];
            }
            std::cout << "\n";
        }
        std::cout << "      " << plugin->file.string() << "\n";
    }
    if (!registry.refused().empty()) {
        std::cout << "refused\n";
    }
    for (const difusa::RefusedPlugin& refused : registry.refused()) {
        std::cout << "  " << refused.file.string() << "\n      " << refused.reason << "\n";
    }
}

void check_files(const Arguments& a) {
    if (a.mesh.empty()) {
        throw UsageError("a mesh file is expected: bake_radiosity mesh.off out.vtp (--help)");
    }
    if (a.files.field.empty() && !a.dry_run) {
        throw UsageError("an output file is expected: bake_radiosity " + a.mesh.string() + " out.vtp (--help)");
    }
    difusa::check_outputs({{a.files.field, true}, {a.files.sites, true}, {a.files.report, false}},
                          {{a.mesh, "the mesh"}});
}

void print_details(const difusa::BakeResult& result) {
    for (const auto& [kind, choice] : result.plugins) {
        std::cout << kind << ": " << choice << "\n";
    }
    for (const auto& [phase, took] : result.seconds) {
        std::cout << "time, " << phase << ": " << difusa::format_seconds(took) << "\n";
    }
    for (std::size_t c = 0; c < result.solve.residual_history.size(); ++c) {
        std::cout << "residuals, channel " << c << ":";
        for (const double residual : result.solve.residual_history[c]) {
            std::cout << " " << residual;
        }
        std::cout << "\n";
    }
}

void run(const Arguments& a) {
    const difusa::Registry registry = difusa::Registry::load(a.plugin_path);
    if (a.list_plugins) {
        list_plugins(registry);
        return;
    }
    check_files(a);
    if (a.threads > 1024) {
        throw UsageError("--threads " + std::to_string(a.threads) + ": must be at most 1024");
    }
    registry.describe("kernel", a.bake.kernel); // a wrong name is a mistake even where no kernel is needed

    difusa::TerminalProgress progress(a.quiet);
    const difusa::Execution execution{a.threads, &progress};
    difusa::BakeResult result;
    try {
        result = a.dry_run ? difusa::dry_run(registry, a.mesh, a.bake, execution)
                           : difusa::bake(registry, a.mesh, a.bake, execution);
    } catch (const difusa::Error& error) {
        if (!a.quiet && error.code() != ExitCode::interrupted) {
            progress.print_remarks();
        }
        throw;
    }
    if (a.kernel->count() > 0 && a.bake.transport.rfind("pairwise", 0) != 0) {
        result.notes.push_back("--kernel has no effect on --transport " + a.bake.transport);
    }
    difusa::BakeFiles files = a.files;
    if (a.dry_run) {
        files.field.clear();
        files.sites.clear();
    }
    difusa::write_bake(result, files, execution);
    progress.clear();
    if (a.quiet) {
        return;
    }
    if (a.verbose) {
        print_details(result);
    }
    std::cout << difusa::summary_of(result);
    if (!files.field.empty()) {
        std::cout << "written: " << files.field.string() << " (" << result.mesh.vertices.size() << " vertices, "
                  << result.mesh.triangles.size() << " triangles)\n";
    }
    for (const std::filesystem::path& file : {files.sites, files.report}) {
        if (!file.empty()) {
            std::cout << "written: " << file.string() << "\n";
        }
    }
}

} // namespace

int main(int count, char** words) {
    Arguments arguments;
    CLI::App app(examples, "bake_radiosity");
    declare(app, arguments);
    return difusa::run_command(app, count, words, "one mesh and one output file", arguments.version,
                               [&] { run(arguments); });
}
