// inspect_basis mesh out: shows the finite elements a bake would use. Parses options, inspects, writes files.
#include "bake_arguments.h"
#include "terminal.h"

#include <difusa/import/text_scanner.h>
#include <difusa/output/basis_files.h>
#include <difusa/rays/visibility_choice.h>
#include <difusa/study/inspect_basis.h>

#include <filesystem>
#include <iostream>
#include <set>
#include <string>
#include <vector>

namespace inspect_basis {

using difusa::add_parsed;
using difusa::parse_positive;
using difusa::UsageError;

const char* const examples =
    R"(Shows the finite elements that bake_radiosity would use on a mesh.

Examples:
  inspect_basis mesh.off basis.vtp
      the element in the middle of the surface, and the sum of all; open in ParaView and colour by element
  inspect_basis mesh.off basis.vtp --element 42 --element 43 --basis shepard:k=3
      two elements of another basis; those of a bake with --no-adaptive and the same --seed, --spacing and so on,
      unless that bake leaves out surfaces that no light reaches, or adds sites where none can be seen
  inspect_basis room.obj basis.vtp --near 1.2,0,0.5 --sites-output sites.vtp
      the element nearest to a point; the sites as points, for glyphs scaled by radius or reach

Point arrays of the output: element (and element_N for each additional one), sum (1 for a partition of unity), overlap
(number of nonzero elements), lebesgue (sum of absolute values), nearest_site.

Exit codes: 0 done, 1 usage, 2 input, 3 not converged, 4 resources, 5 internal, 130 interrupted.
)";

struct Arguments {
    std::filesystem::path mesh, field, sites;
    difusa::InspectOptions inspect;
    difusa::RunArguments run;
};

void declare(CLI::App& app, Arguments& a) {
    app.add_option("mesh", a.mesh, difusa::mesh_help)->type_name("MESH");
    app.add_option("out", a.field, "fields on a fine mesh: .vtp (everything), .ply (element as quality) or .glb")
        ->type_name("OUT");

    const std::string what = "Elements";
    difusa::add_repeated(app, "--element", a.inspect.elements, "number of an element, from 0 (may be repeated)",
                         [](const std::string& option, const std::string& text) {
                             return difusa::parse_whole<difusa::Index>(option, text, 0);
                         })
        ->group(what)
        ->type_name("I");
    difusa::add_repeated(app, "--near", a.inspect.near,
                         "the element whose site is nearest to a point (may be repeated)", difusa::parse_point)
        ->group(what)
        ->type_name("X,Y,Z");

    const std::string discretisation = "Discretisation";
    add_site_arguments(app, a.inspect, discretisation);
    app.add_option("--visibility", a.inspect.visibility,
                   "ray casting for samplers that need it: embree or cgal; auto: embree if available, otherwise cgal")
        ->group(discretisation)
        ->type_name("NAME")
        ->capture_default_str();

    const std::string output = "Output";
    add_parsed(app, "--output-spacing", a.inspect.output_spacing,
               "longest edge of the output mesh (default: a sixth of the site spacing)", parse_positive)
        ->group(output)
        ->type_name("D");
    app.add_option("--sites-output", a.sites, "write the sites with their elements' measures, .vtp, .ply or .glb")
        ->group(output)
        ->type_name("FILE");

    add_run_arguments(app, a.run, a.inspect.seed, "the result does not depend");
}

void run(Arguments& a) {
    const difusa::Registry registry = difusa::Registry::load(a.run.plugin_path);
    if (a.mesh.empty()) {
        throw UsageError("a mesh file is expected: inspect_basis mesh.off basis.vtp (--help)");
    }
    if (a.field.empty()) {
        throw UsageError("an output file is expected: inspect_basis " + a.mesh.string() + " basis.vtp (--help)");
    }
    difusa::check_outputs({{a.field, true}, {a.sites, true}}, {{a.mesh, "the mesh"}});
    const std::set<difusa::Index> elements(a.inspect.elements.begin(), a.inspect.elements.end());
    if (difusa::lower_case(a.field.extension().string()) == ".ply" && elements.size() + a.inspect.near.size() > 1) {
        throw UsageError("--element, --near: a .ply holds a single element; write " + a.field.string() +
                         " as a .vtp, which holds several");
    }
    a.inspect.outputs = {a.field, a.sites};
    // A wrong name is an error even if none is needed.
    std::vector<std::string> notes;
    difusa::choose_visibility(registry, a.inspect.visibility, notes);

    difusa::TerminalProgress progress(a.run.quiet);
    const difusa::Execution execution = a.run.execution(progress);
    const difusa::BasisInspection inspection = difusa::inspect_basis(registry, a.mesh, a.inspect, execution);
    difusa::write_inspection(inspection, a.field, a.sites, execution);
    progress.clear();
    if (a.run.quiet) {
        return;
    }
    std::cout << difusa::summary_of(inspection) << "written: " << a.field.string() << " ("
              << inspection.output.vertices.size() << " vertices, " << inspection.output.triangles.size()
              << " triangles)\n";
    if (!a.sites.empty()) {
        std::cout << "written: " << a.sites.string() << "\n";
    }
}

int program(int count, char** words) {
    Arguments arguments;
    CLI::App app(examples, "inspect_basis");
    declare(app, arguments);
    return difusa::run_command(app, count, words, "one mesh and one output file", arguments.run.version,
                               [&] { run(arguments); });
}

} // namespace inspect_basis
