// inspect_basis mesh out: shows the finite elements that a bake would use. Options in, inspection, files out.
#include "arguments.h"
#include "terminal.h"

#include <difusa/analysis/inspect_basis.h>
#include <difusa/io/basis_files.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <string>
#include <thread>
#include <vector>

namespace {

using difusa::add_parsed;
using difusa::add_whole;
using difusa::parse_positive;
using difusa::shown;
using difusa::UsageError;

const char* const examples =
    R"(Shows the finite elements that bake_radiosity would use on a mesh.

Examples:
  inspect_basis mesh.off basis.vtp
      the element in the middle of the surface, and the sum of all; open in ParaView and colour by element
  inspect_basis mesh.off basis.vtp --element 42 --element 43 --basis shepard:k=3
      two elements of another basis; --seed, --spacing and the like as for a bake, the elements are the same
  inspect_basis room.obj basis.vtp --near 1.2,0,0.5 --sites-output sites.vtp
      the element nearest to a point; the sites as points, for glyphs scaled by radius or reach

Point arrays of the output: element (and element_N for every further one), sum (1 for a partition of unity), overlap
(number of elements that do not vanish), lebesgue (sum of absolute values), nearest_site.

Exit codes: 0 done, 1 usage, 2 input, 3 not converged, 4 resources, 5 internal, 130 interrupted.
)";

struct Arguments {
    std::filesystem::path mesh, field, sites;
    std::vector<std::filesystem::path> plugin_path;
    difusa::InspectOptions inspect;
    unsigned threads = std::max(1U, std::thread::hardware_concurrency());
    bool quiet = false, version = false;
};

difusa::Vec3 parse_point(const std::string& option, const std::string& text) {
    const auto values = difusa::parse_numbers(text);
    if (!values || values->size() != 3) {
        throw UsageError(option + " " + text + ": takes three numbers X,Y,Z with nothing but commas between");
    }
    return {(*values)[0], (*values)[1], (*values)[2]};
}

/// An option that may be repeated; `parse` turns each text into one more entry of `target`.
template <class T, class Parse>
CLI::Option* add_repeated(CLI::App& app, const std::string& name, std::vector<T>& target, const std::string& what,
                          Parse parse) {
    return app
        .add_option_function<std::vector<std::string>>(
            name,
            [&target, name, parse](const std::vector<std::string>& texts) {
                for (const std::string& text : texts) {
                    target.push_back(parse(name, text));
                }
            },
            what)
        ->expected(-1)
        ->allow_extra_args(false); // one text each time
}

void declare(CLI::App& app, Arguments& a) {
    app.add_option("mesh", a.mesh, "mesh or scene: .off .obj .ply .stl .gltf .glb .json")->type_name("MESH");
    app.add_option("out", a.field, "fields on a fine mesh: .vtp (everything) or .ply (element as quality)")
        ->type_name("OUT");

    const std::string what = "Elements";
    add_repeated(app, "--element", a.inspect.elements, "number of an element, from 0 (may be repeated)",
                 [](const std::string& option, const std::string& text) {
                     return difusa::parse_whole<difusa::Index>(option, text, 0);
                 })
        ->group(what)
        ->type_name("I");
    add_repeated(app, "--near", a.inspect.near, "the element whose site is nearest to a point (may be repeated)",
                 parse_point)
        ->group(what)
        ->type_name("X,Y,Z");

    const std::string discretisation = "Discretisation";
    app.add_option("--basis", a.inspect.basis, "finite elements")
        ->group(discretisation)
        ->type_name("NAME")
        ->capture_default_str();
    app.add_option("--sampler", a.inspect.sampler, "where the sites go")
        ->group(discretisation)
        ->type_name("NAME")
        ->capture_default_str();
    app.add_option("--visibility", a.inspect.visibility, "ray casting of samplers that need it: cgal or embree")
        ->group(discretisation)
        ->type_name("NAME")
        ->capture_default_str();
    add_parsed(app, "--spacing", a.inspect.spacing, "least distance between sites, in units of the mesh",
               parse_positive)
        ->group(discretisation)
        ->type_name("D");
    add_whole<std::size_t>(app, "--sites", a.inspect.sites, 1,
                           "wanted number of sites, instead of --spacing (default 4000)")
        ->group(discretisation)
        ->type_name("N");
    add_whole(app, "--neighbours", a.inspect.neighbours, 1, "a site's radius reaches to its M-th nearest site")
        ->group(discretisation)
        ->type_name("M")
        ->default_str(shown(a.inspect.neighbours));

    const std::string output = "Output";
    add_parsed(app, "--output-spacing", a.inspect.output_spacing,
               "longest edge of the output mesh (default: a sixth of the site spacing)", parse_positive)
        ->group(output)
        ->type_name("D");
    app.add_option("--sites-output", a.sites, "write the sites with their elements' measures, .vtp or .ply")
        ->group(output)
        ->type_name("FILE");

    const std::string run = "Running";
    add_whole<std::uint64_t>(app, "--seed", a.inspect.seed, 0, "of all random choices")
        ->group(run)
        ->type_name("N")
        ->default_str(shown(a.inspect.seed));
    add_whole(app, "--threads", a.threads, 1U, "threads; the result does not depend on it")
        ->group(run)
        ->type_name("N")
        ->default_str(shown(a.threads));
    app.add_option("--plugin-path", a.plugin_path, "another directory with plugins (may be repeated)")
        ->group(run)
        ->type_name("DIR")
        ->expected(-1)
        ->allow_extra_args(false); // one directory each time
    app.add_flag("--quiet", a.quiet, "only errors")->group(run);
    app.add_flag("--version", a.version, "version, and those of the libraries")->group(run);
}

void run(const Arguments& a) {
    const difusa::Registry registry = difusa::Registry::load(a.plugin_path);
    if (a.mesh.empty()) {
        throw UsageError("a mesh file is expected: inspect_basis mesh.off basis.vtp (--help)");
    }
    if (a.field.empty()) {
        throw UsageError("an output file is expected: inspect_basis " + a.mesh.string() + " basis.vtp (--help)");
    }
    difusa::check_outputs({{a.field, true}, {a.sites, true}}, {{a.mesh, "the mesh"}});
    if (a.threads > 1024) {
        throw UsageError("--threads " + std::to_string(a.threads) + ": must be at most 1024");
    }
    registry.describe("visibility", a.inspect.visibility); // a wrong name is a mistake even where none is needed

    difusa::TerminalProgress progress(a.quiet);
    const difusa::Execution execution{a.threads, &progress};
    const difusa::BasisInspection inspection = difusa::inspect_basis(registry, a.mesh, a.inspect, execution);
    difusa::write_inspection(inspection, a.field, a.sites, execution);
    progress.clear();
    if (a.quiet) {
        return;
    }
    std::cout << difusa::summary_of(inspection) << "written: " << a.field.string() << " ("
              << inspection.output.vertices.size() << " vertices, " << inspection.output.triangles.size()
              << " triangles)\n";
    if (!a.sites.empty()) {
        std::cout << "written: " << a.sites.string() << "\n";
    }
}

} // namespace

int main(int count, char** words) {
    Arguments arguments;
    CLI::App app(examples, "inspect_basis");
    declare(app, arguments);
    return difusa::run_command(app, count, words, "one mesh and one output file", arguments.version,
                               [&] { run(arguments); });
}
