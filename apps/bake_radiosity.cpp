// bake_radiosity mesh out: bakes diffuse global illumination onto a mesh. Parses options, bakes, writes files.
#include "bake_arguments.h"
#include "run_bake.h"

#include <difusa/bake.h>
#include <difusa/import/text_scanner.h>
#include <difusa/output/series_files.h>
#include <difusa/rays/visibility_choice.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

namespace bake_radiosity {

using difusa::UsageError;

const char* const examples =
    R"(Bakes diffuse global illumination (radiosity) onto a mesh.

Examples:
  bake_radiosity mesh.off out.vtp
      bake with defaults; open out.vtp in ParaView and colour by radiosity or display_rgb
  bake_radiosity room.obj out.ply --rays 2048 --sites 10000
      a finer bake for MeshLab; materials with Ke emit light
  bake_radiosity room.obj out.vtp --basis shepard:k=3 --spacing 0.05 --report out.json --sites-output sites.vtp
      another basis, a given site spacing, a report, and the sites as points
  bake_radiosity hall.ply out.vtp --sky 1,1.1,1.3 --reflectance 0.7
      sky light on a mesh without colours
  bake_radiosity oven.json out.vtp
      temperatures and net fluxes, if the materials of the scene are thermal ones
  bake_radiosity room.obj out.vtp --dry-run
      number of sites and rays, memory and time it would take
  bake_radiosity room.obj out.vtp --save-transport room.difusa
      and then relight room.difusa, in other light or colours, without casting the rays again
  bake_radiosity --list-plugins

Exit codes: 0 done, 1 usage, 2 input, 3 not converged or --error not reached, 4 resources, 5 internal, 130 interrupted.
)";

struct Arguments {
    std::filesystem::path mesh;
    difusa::BakeArguments bake;
    difusa::RunArguments run;
    std::filesystem::path convergence;
    bool list_plugins = false, dry_run = false, verbose = false;
};

void declare(CLI::App& app, Arguments& a) {
    app.add_option("mesh", a.mesh, difusa::mesh_help)->type_name("MESH");
    add_bake_arguments(app, a.bake, "each output vertex");
    add_mesh_output_arguments(app, a.bake);
    app.add_option("--save-transport", a.bake.files.transport,
                   "also write what depends on the surface alone, for `relight`, which lights it anew without casting "
                   "the rays again; puts sites on all surfaces, also on those that these lights do not reach")
        ->group("Output")
        ->type_name("FILE");

    app.add_option("--convergence", a.convergence,
                   "also write what the solver passes through on its way, as a series that ParaView plays, and a .vtp "
                   "for each; --solver progressive shows most")
        ->group("Output")
        ->type_name("FILE.pvd");

    add_run_arguments(app, a.run, a.bake.options.seed, "the result does not depend");
    const std::string run = difusa::run_group;
    app.add_flag("--dry-run", a.dry_run, "estimate what the bake would take, and stop; writes nothing but --report")
        ->group(run);
    app.add_flag("--verbose", a.verbose, "also print choices, times and residuals")->group(run);
    app.add_flag("--list-plugins", a.list_plugins, "list all plugins with their parameters, refused ones included")
        ->group(run);
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
            if (kind == difusa::kind_of<difusa::Visibility>()) {
                std::cout << "  auto  The first of";
                for (const std::string_view name : difusa::preferred_visibility) {
                    std::cout << " " << name << ",";
                }
                std::cout << " and any other that is found and starts (the default).\n";
            }
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

/// The series of --convergence, and the members that it may have.
std::vector<difusa::OutputName> series_of(const Arguments& a) {
    std::vector<difusa::OutputName> files;
    if (!a.convergence.empty()) {
        files.push_back({a.convergence, false});
        for (std::size_t i = 0; i < difusa::most_iterates; ++i) {
            files.push_back({difusa::series_member(a.convergence, i), true});
        }
    }
    return files;
}

void check_files(const Arguments& a) {
    if (a.mesh.empty()) {
        throw UsageError("a mesh file is expected: bake_radiosity mesh.off out.vtp (--help)");
    }
    if (a.bake.files.field.empty() && !a.dry_run) {
        throw UsageError("an output file is expected: bake_radiosity " + a.mesh.string() + " out.vtp (--help)");
    }
    if (!a.convergence.empty()) {
        if (difusa::lower_case(a.convergence.extension().string()) != ".pvd") {
            throw UsageError("--convergence " + a.convergence.string() +
                             ": must end in .pvd (a series that ParaView plays)");
        }
        if (a.bake.error) {
            throw UsageError("--convergence: is of one bake, and --error takes several; omit one of them");
        }
    }
    check_bake_outputs(a.bake, series_of(a), {{a.mesh, "the mesh"}});
}

void run(const Arguments& a) {
    const difusa::Registry registry = difusa::Registry::load(a.run.plugin_path);
    if (a.list_plugins) {
        list_plugins(registry);
        return;
    }
    check_files(a);
    difusa::BakeOptions options = bake_options(a.bake, registry);
    options.every_surface = !a.bake.files.transport.empty();
    if (options.every_surface) {
        options.when_visible = [](const auto& scene, const auto&...) {
            if (scene.mesh.glossy.any()) {
                throw difusa::UsageError(
                    "--save-transport: the transport over glossy materials cannot be saved; remove the "
                    "option, or use --no-gloss");
            }
        };
    }
    grade_by_default(a.bake, registry, options);
    difusa::BakeFiles files = a.bake.files;
    if (a.dry_run) {
        files = {.report = files.report};
    }
    options.keep_iterates = !a.convergence.empty();
    for (const difusa::OutputName& member : series_of(a)) {
        options.outputs.push_back(member.file);
    }
    difusa::SeriesWriter series(a.convergence, {});
    run_bake(files, a.run, a.verbose, [&](const difusa::Execution& execution) {
        if (a.dry_run) {
            return difusa::dry_run(registry, a.mesh, options, execution);
        }
        difusa::BakeResult result = difusa::bake(registry, a.mesh, options, execution);
        series.add_iterates(result, execution);
        return result;
    });
    if (series.size() > 0) {
        const std::size_t count = series.size();
        series.commit();
        if (!a.run.quiet) {
            std::cout << "written: " << a.convergence.string() << " (" << count << " iterates)\n";
        }
    }
}

int program(int count, char** words) {
    Arguments arguments;
    CLI::App app(examples, "bake_radiosity");
    declare(app, arguments);
    return difusa::run_command(app, count, words, "one mesh and one output file", arguments.run.version,
                               [&] { run(arguments); });
}

} // namespace bake_radiosity
