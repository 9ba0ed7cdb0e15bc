// form_factors mesh out: the matrix of view factors of a surface. Parses options, computes, writes the file.
#include "arguments.h"
#include "terminal.h"

#include <difusa/bake/scene.h>
#include <difusa/core/digits.h>
#include <difusa/core/text.h>
#include <difusa/form_factors/by_rays.h>
#include <difusa/form_factors/closure.h>
#include <difusa/form_factors/enclosure.h>
#include <difusa/form_factors/form_factors.h>
#include <difusa/form_factors/grouped.h>
#include <difusa/io/whole_file.h>
#include <difusa/output/enclosure_files.h>
#include <difusa/output/form_factor_files.h>
#include <difusa/plugin/registry.h>
#include <difusa/rays/visibility_choice.h>
#include <difusa/repair/covered_parts.h>
#include <difusa/repair/diagnosis.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

namespace form_factors {

using difusa::add_parsed;
using difusa::add_whole;
using difusa::UsageError;

const char* const examples =
    R"(Computes the form factors (view factors) between the faces of a mesh, with a tolerance for each.

Examples:
  form_factors box.off factors.csv
      between all faces, each within 1e-6: a line for each pair that sees each other, with an estimate of its error
  form_factors room.obj factors.csv --surfaces material --layout dense
      between materials: a matrix with areas, row sums and what escapes; small ones are printed, too
  form_factors furnace_box.obj factors.npz --tolerance 1e-8 --close
      for scipy.sparse.load_npz; row sums of a closed surface made exactly 1 by the smallest change of the factors
  form_factors building.obj factors.npz --tolerance 1e-3 --layout grouped
      far triangles in groups, for large meshes: a number for a pair of groups instead of one for each pair of triangles
  form_factors oven.json factors.csv --surfaces material --thermal heat.csv
      and the temperatures, net fluxes and radiosities of a thermal scene's surfaces
  form_factors furnace_box.obj factors.mtx --method rays --rays 4096 --points 4
      for comparison: counted by rays from four points of each triangle

F_ij is the share of what leaves the front of surface i that arrives at the front of surface j first. What is missing
from a row sum of 1 escapes, or meets the backs of faces.

Exit codes: 0 done, 1 usage, 2 input (with --close also an open surface), 3 no factors with closure were found, 4
resources, 5 internal, 130 interrupted.
)";

struct Arguments {
    std::filesystem::path mesh, out, thermal;
    std::string method = "exact", surfaces = "face", layout = "sparse";
    std::optional<double> tolerance;
    std::optional<std::size_t> rays, points;
    std::optional<std::string> directions, visibility;
    bool close = false;
    std::uint64_t seed = 0;
    bool seeded = false; ///< `seed` was given
    difusa::RunArguments run;
};

std::string one_of(const std::string& option, const std::string& text, const std::vector<std::string>& known) {
    if (std::find(known.begin(), known.end(), text) == known.end()) {
        std::string list;
        for (const std::string& name : known) {
            list += (list.empty() ? "" : ", ") + name;
        }
        throw UsageError(option + " " + text + ": must be one of " + list);
    }
    return text;
}

/// Errors are estimated by how the points of a triangle differ.
std::size_t parse_points(const std::string& option, const std::string& text) {
    const auto points = difusa::parse_whole<std::size_t>(option, text, 1);
    if (points < 2) {
        throw UsageError(option + " " + text +
                         ": must be at least 2: errors are estimated from the differences "
                         "between the points of a triangle, and one has none");
    }
    return points;
}

void declare(CLI::App& app, Arguments& a) {
    app.add_option("mesh", a.mesh, "mesh or scene file: .off .obj .ply .stl .gltf .glb .json")->type_name("MESH");
    app.add_option("out", a.out, "form factors: .csv (a table), .npz (NumPy, SciPy) or .mtx (Matrix Market)")
        ->type_name("OUT");

    const std::string what = "Form factors";
    add_parsed(app, "--method", a.method,
               "exact: contour integrals, and exact visibility where something is in between; rays: the hits of rays, "
               "from points of each triangle",
               [](const std::string& option, const std::string& text) {
                   return one_of(option, text, {"exact", "rays"});
               })
        ->group(what)
        ->type_name("NAME")
        ->default_str(a.method);
    add_parsed(app, "--tolerance", a.tolerance, "of each form factor, absolute (default: 1e-6; method exact)",
               difusa::parse_positive)
        ->group(what)
        ->type_name("T");
    add_parsed(app, "--surfaces", a.surfaces,
               "between what: face (of the file), material, or group (light groups of materials)",
               [](const std::string& option, const std::string& text) {
                   return one_of(option, text, {"face", "material", "group"});
               })
        ->group(what)
        ->type_name("NAME")
        ->default_str(a.surfaces);
    app.add_flag("--close", a.close,
                 "make all row sums of a closed surface 1, keeping reciprocity and factors of at least 0, by the "
                 "smallest change in least squares")
        ->group(what);
    add_parsed(app, "--layout", a.layout,
               "sparse: what is not 0; dense: the whole matrix; grouped: one for each pair of groups of triangles, "
               "which are the larger the farther apart they are",
               [](const std::string& option, const std::string& text) {
                   return one_of(option, text, {"sparse", "dense", "grouped"});
               })
        ->group(what)
        ->type_name("NAME")
        ->default_str(a.layout);

    app.add_option(
           "--thermal", a.thermal,
           "also write what a thermal scene comes to, each surface of uniform radiosity: temperature, net flux, "
           "heat; backs of double-sided materials are then surfaces of their own")
        ->group(what)
        ->type_name("FILE.csv");

    const std::string rays = "Method rays";
    const auto whole = [](const std::string& option, const std::string& text) {
        return difusa::parse_whole<std::size_t>(option, text, 1);
    };
    add_parsed(app, "--rays", a.rays, "rays from each point (default: 1024)", whole)->group(rays)->type_name("N");
    add_parsed(app, "--points", a.points, "points on each triangle, at least 2 (default: 4)", parse_points)
        ->group(rays)
        ->type_name("N");
    const auto word = [](const std::string&, const std::string& text) { return text; };
    add_parsed(app, "--directions", a.directions, "set of directions (default: fibonacci)", word)
        ->group(rays)
        ->type_name("NAME");
    add_parsed(app, "--visibility", a.visibility, "ray casting: embree, cgal or auto (default: auto)", word)
        ->group(rays)
        ->type_name("NAME");

    add_run_arguments(app, a.run, a.seed, "the result does not depend");
}

void check(const Arguments& a) {
    if (a.mesh.empty()) {
        throw UsageError("a mesh file is expected: form_factors mesh.off factors.csv (--help)");
    }
    if (a.out.empty()) {
        throw UsageError("an output file is expected: form_factors " + a.mesh.string() + " factors.csv (--help)");
    }
    if (a.method == "exact" && (a.rays || a.points || a.directions || a.visibility || a.seeded)) {
        throw UsageError("--rays, --points, --directions, --visibility and --seed belong to --method rays");
    }
    if (a.method != "exact" && a.tolerance) {
        throw UsageError("--tolerance belongs to --method exact: the number of rays and points decides the error of "
                         "others");
    }
    if (a.layout == "grouped") {
        if (a.method != "exact" || a.surfaces != "face" || a.close || !a.thermal.empty()) {
            throw UsageError(
                "--layout grouped: is for the triangles of the mesh by --method exact, without --surfaces, "
                "--close and --thermal");
        }
        difusa::check_grouped_file(a.out);
    }
    difusa::check_form_factor_file(a.out);
    if (!a.thermal.empty()) {
        difusa::check_enclosure_file(a.thermal);
    }
    difusa::check_outputs({{a.out, false}, {a.thermal, false}}, {{a.mesh, "the mesh"}});
}

/// A surface with names for its parts.
struct Input {
    difusa::Scene scene;
    bool has_borders = false;
};

void settle_thermal(const Arguments& a, const difusa::PolygonSoup& soup, difusa::Scene& scene) {
    if (soup.surroundings) {
        scene.thermal = difusa::ThermalSetting{soup.surroundings};
    }
    try {
        difusa::settle_thermal(scene);
    } catch (const difusa::InputError& error) {
        throw difusa::InputError(a.mesh.string() + ": " + error.what());
    }
    if (!scene.thermal) {
        throw UsageError("--thermal: " + a.mesh.string() +
                         " is not a thermal scene: give its materials temperatures or net fluxes in a scene file "
                         "(data/THERMAL.md)");
    }
}

Input read(const Arguments& a, const difusa::Registry& registry, const difusa::Execution& execution) {
    execution.phase("read");
    const difusa::PolygonSoup soup = difusa::read_apart_from({a.out, a.thermal}, registry, a.mesh);
    if (!soup.repetition.planes.empty() || !soup.repetition.periods.empty()) {
        throw difusa::InputError(a.mesh.string() +
                                 ": has symmetry planes or periods, beyond which form factors are not computed: name "
                                 "its mesh, or a scene of the whole surface");
    }
    execution.phase("check mesh");
    difusa::DiagnosedMesh diagnosed = difusa::diagnose(soup, execution);
    Input input;
    difusa::Scene& scene = input.scene;
    scene.mesh = std::move(diagnosed.mesh);
    scene.materials = soup.materials;
    scene.materials.emplace_back();
    scene.materials.back().name = "default"; // of faces without one
    if (!a.thermal.empty()) {
        scene.suns = soup.lights.suns;
        scene.point_lights = soup.lights.points;
        scene.sky = soup.lights.sky.value_or(difusa::Rgb::Zero());
        scene.dome = soup.lights.dome;
        settle_thermal(a, soup, scene);
    }
    for (const std::string& what : soup.notes) {
        execution.note(what);
    }
    const difusa::CoveredParts covered = difusa::leave_out_covered(scene.mesh, execution);
    std::vector<difusa::Finding>& findings = diagnosed.diagnosis.findings;
    const std::vector<difusa::Finding> further =
        difusa::findings_of(difusa::Defect::covered_parts, covered.cut, covered.given_up, diagnosed.diagnosis);
    findings.insert(findings.end(), further.begin(), further.end());
    for (const difusa::Finding& finding : findings) {
        input.has_borders = input.has_borders || finding.code == "border-edges";
        if (const std::string remark = finding.remark(); !remark.empty()) {
            execution.note(finding.repaired ? remark : finding.message());
        }
    }
    return input;
}

difusa::Surfaces surfaces_of(const Arguments& a, const Input& input) {
    const difusa::Scene& scene = input.scene;
    if (a.surfaces == "face") {
        return difusa::surfaces_by_face(scene.mesh);
    }
    difusa::Surfaces surfaces = a.surfaces == "group" ? difusa::surfaces_by_group(scene.mesh, scene.materials)
                                                      : difusa::surfaces_by_material(scene.mesh, scene.materials);
    return a.thermal.empty() ? surfaces : difusa::with_backs_apart(scene.mesh, surfaces);
}

/// The material of each surface. Surfaces by face or material have one, and groups of thermal materials, too.
std::vector<difusa::Index> materials_of(const difusa::Scene& scene, const difusa::Surfaces& surfaces) {
    std::vector<difusa::Index> material(surfaces.size(), difusa::none);
    for (std::size_t t = 0; t < surfaces.of.size(); ++t) {
        material[surfaces.of[t]] = scene.mesh.material[t];
    }
    return material;
}

difusa::FormFactors by_rays(const Arguments& a, const difusa::Registry& registry, const Input& input,
                            const difusa::Surfaces& surfaces, const difusa::Execution& execution) {
    std::vector<std::string> notes;
    const auto engine =
        registry.create<difusa::Visibility>(difusa::choose_visibility(registry, a.visibility.value_or("auto"), notes));
    for (const std::string& note : notes) {
        execution.note(note);
    }
    const std::string choice = a.directions.value_or("fibonacci");
    const auto directions = registry.create<difusa::Directions>(choice);
    if (a.rays) {
        difusa::check_rays(*a.rays, choice, *directions);
    }
    engine->build(input.scene.mesh);
    const difusa::DirectionPool pool(*directions, a.rays.value_or(1024), a.seed);
    return difusa::form_factors_by_rays(difusa::Tracer(input.scene.mesh, *engine), surfaces, pool, a.points.value_or(4),
                                        a.seed, execution);
}

/// "1 - 3.8e-08" near 1, "0.561437" elsewhere.
std::string sum_text(double sum) {
    constexpr double near = 0.01;
    const double more = sum - 1.0;
    if (more == 0.0 || !(std::abs(more) < near)) {
        return difusa::text_of(sum);
    }
    return std::string("1 ") + (more < 0.0 ? "- " : "+ ") + difusa::with_digits(std::abs(more), 2);
}

void print_sums(double least, double largest, bool has_borders) {
    std::cout << "row sums: " << sum_text(least) << " to " << sum_text(largest)
              << (has_borders ? " (the surface has borders: the rest escapes)" : "") << "\n";
}

void print(const Arguments& a, const Input& input, const difusa::FormFactors& F, const difusa::Surfaces& surfaces,
           double seconds) {
    using difusa::counted, difusa::text_of;
    const double tolerance = a.tolerance.value_or(difusa::FormFactorOptions().tolerance);
    const difusa::FormFactorLaws laws = difusa::check_laws(F, tolerance);
    std::cout << table_of(F, surfaces) << "surfaces: " << F.size() << " ("
              << counted(input.scene.mesh.triangles.size(), "triangle") << "), " << counted(F.nonzeros(), "form factor")
              << " above 0\n";
    print_sums(laws.least_row_sum, laws.largest_row_sum, input.has_borders);
    std::cout << "reciprocity: A_i F_ij and A_j F_ji differ by at most " << text_of(laws.reciprocity)
              << " of the smaller area\n"
              << "estimated errors: at most " << text_of(laws.largest_error);
    if (a.method == "exact") {
        std::cout << "; above the tolerance of " << text_of(tolerance) << ": " << laws.above_tolerance;
    }
    std::cout << "\ntime: " << text_of(seconds) << " s for the form factors\nwritten: " << a.out.string() << "\n";
}

/// Links between groups of triangles.
void compute_grouped(const Arguments& a, const Input& input, const difusa::Execution& execution,
                     difusa::TerminalProgress& progress) {
    difusa::FormFactorOptions options;
    options.tolerance = a.tolerance.value_or(options.tolerance);
    const auto began = std::chrono::steady_clock::now();
    const difusa::GroupedFormFactors F = difusa::grouped_form_factors(input.scene.mesh, options, execution);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
    execution.phase("write");
    difusa::write_form_factors(F, surfaces_of(a, input), a.out);
    if (a.run.quiet) {
        return;
    }
    progress.print_remarks();
    const std::vector<double> sums = F.row_sums();
    float largest = 0.0F;
    for (const difusa::GroupedFormFactors::Link& link : F.links) {
        largest = std::max(largest, link.error);
    }
    std::cout << "triangles: " << sums.size() << ", in " << difusa::counted(F.groups.size(), "group") << " with "
              << difusa::counted(F.links.size(), "link") << "\n";
    print_sums(*std::min_element(sums.begin(), sums.end()), *std::max_element(sums.begin(), sums.end()),
               input.has_borders);
    std::cout << "estimated errors: at most " << difusa::text_of(largest)
              << ", of the factor from a triangle to a group\ntime: " << difusa::text_of(took.count())
              << " s for the form factors\nwritten: " << a.out.string() << "\n";
}

void compute(const Arguments& a, difusa::TerminalProgress& progress) {
    const difusa::Registry registry = difusa::Registry::load(a.run.plugin_path);
    const difusa::Execution execution = a.run.execution(progress);
    const Input input = read(a, registry, execution);
    if (a.layout == "grouped") {
        compute_grouped(a, input, execution, progress);
        return;
    }
    const difusa::Surfaces surfaces = surfaces_of(a, input);
    const auto began = std::chrono::steady_clock::now();
    difusa::FormFactors F;
    if (a.method == "exact") {
        difusa::FormFactorOptions options;
        options.tolerance = a.tolerance.value_or(options.tolerance);
        F = difusa::form_factors(input.scene.mesh, surfaces, options, execution);
    } else {
        F = by_rays(a, registry, input, surfaces, execution);
    }
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
    std::optional<difusa::ClosureCorrection> correction;
    if (a.close) {
        execution.phase("closure");
        correction = difusa::enforce_closure(F, surfaces.name);
    }
    std::optional<difusa::Enclosure> enclosure;
    if (!a.thermal.empty()) {
        execution.phase("exchange heat");
        try {
            enclosure = solve_enclosure(input.scene, F, materials_of(input.scene, surfaces), surfaces.name, execution);
        } catch (const difusa::InputError& error) {
            throw difusa::InputError(a.mesh.string() + ": " + error.what());
        }
    }
    execution.phase("write");
    std::optional<difusa::WholeFile> table; // both files appear, or none
    if (enclosure) {
        table.emplace(a.thermal);
        table->write(enclosure_table(input.scene, *enclosure, surfaces.name));
    }
    const bool dense = a.layout == "dense";
    difusa::write_form_factors(F, surfaces, dense ? difusa::FormFactorLayout::dense : difusa::FormFactorLayout::sparse,
                               a.out);
    if (table) {
        table->commit();
    }
    if (a.run.quiet) {
        return;
    }
    progress.print_remarks();
    if (correction) {
        std::cout << "closure: form factors changed by at most " << difusa::text_of(correction->largest) << ", "
                  << difusa::text_of(100.0 * correction->rms_relative) << " % rms; row sums are 1 within "
                  << difusa::text_of(correction->row_sum_error) << "\n";
    }
    print(a, input, F, surfaces, took.count());
    if (enclosure) {
        std::cout << enclosure_summary(input.scene, *enclosure, surfaces.name) << "written: " << a.thermal.string()
                  << "\n";
    }
}

void run(const Arguments& a) {
    check(a);
    difusa::TerminalProgress progress(a.run.quiet);
    progress.watch([&] { compute(a, progress); });
}

int program(int count, char** words) {
    Arguments arguments;
    CLI::App app(examples, "form_factors");
    declare(app, arguments);
    return difusa::run_command(app, count, words, "one mesh and one output file", arguments.run.version, [&] {
        arguments.seeded = app.count("--seed") > 0;
        run(arguments);
    });
}

} // namespace form_factors
