// The options that control a bake, for every program that bakes: they fill BakeOptions.
#pragma once

#include "arguments.h"

#include <difusa/bake.h>
#include <difusa/output/bake_files.h>

#include <CLI/CLI.hpp>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace difusa {

/// The help text of a mesh or scene file.
inline constexpr const char* mesh_help = "mesh or scene: .off .obj .ply .stl .gltf .glb .json";

/// --basis --sampler --spacing --sites --neighbours, of a BakeOptions or InspectOptions.
template <class Options> void add_site_arguments(CLI::App& app, Options& options, const std::string& group) {
    CLI::Option* const basis = app.add_option("--basis", options.basis, "finite elements")
                                   ->group(group)
                                   ->type_name("NAME")
                                   ->capture_default_str();
    if (options.basis.empty()) {
        basis->description("finite elements (default: moving-least-squares; normalized-radial for pairwise transport, "
                           "or if bounces do not die out otherwise)");
    }
    app.add_option("--sampler", options.sampler,
                   "how the sites are placed (default: poisson-disk, or what the basis demands)")
        ->group(group)
        ->type_name("NAME")
        ->capture_default_str();
    add_parsed(app, "--spacing", options.spacing,
               "minimum distance between sites, in units of the mesh (metres for a scene file)", parse_positive)
        ->group(group)
        ->type_name("D");
    add_whole<std::size_t>(app, "--sites", options.sites, 1,
                           "desired number of sites, instead of --spacing (default 5000)")
        ->group(group)
        ->type_name("N");
    add_whole(app, "--neighbours", options.neighbours, 1, "a site's radius reaches its M-th nearest site")
        ->group(group)
        ->type_name("M")
        ->default_str(shown(options.neighbours));
}

/// --direct --visibility --kernel.
void add_light_arguments(CLI::App& app, BakeOptions& options, const std::string& group);

/// --direct --visibility.
void add_direct_arguments(CLI::App& app, BakeOptions& options, const std::string& group);

/// --solver --tolerance --max-iterations.
void add_solver_arguments(CLI::App& app, BakeOptions& options, const std::string& group);

/// --sky --sun --point-light --light-groups.
void add_lamp_arguments(CLI::App& app, BakeOptions& options);

/// The values of these options.
struct BakeArguments {
    BakeOptions options;        ///< except `at` and `goals`
    BakeFiles files;            ///< the field and the transport are those of programs that write them
    std::filesystem::path at;   ///< file with points
    std::filesystem::path goal; ///< file with goals
    /// Whether the command line has an option of this name; set by add_result_arguments, and valid as long as its app.
    std::function<bool(const std::string& option)> given;
    std::optional<double> error; ///< to reach
    ErrorTarget target;          ///< its limits
};

/// All options of a bake except --seed and those of its output mesh, in groups; `gathered` says where --final-gather
/// gathers: "each output vertex".
void add_bake_arguments(CLI::App& app, BakeArguments& arguments, const std::string& gathered);

/// What comes out, beside the light on the output mesh: --final-gather, --error-points, goals, units, places, sites,
/// report. Part of the above.
void add_result_arguments(CLI::App& app, BakeArguments& arguments, const std::string& gathered);

/// The output file, --output-spacing and --face-centres.
void add_mesh_output_arguments(CLI::App& app, BakeArguments& arguments);

/// `check_outputs` with the files of the bake added. Throws UsageError for --at without --at-output, for options of
/// places without any, and for what a .ply or .glb cannot hold.
void check_bake_outputs(const BakeArguments& arguments, std::vector<OutputName> outputs,
                        std::vector<std::pair<std::filesystem::path, std::string>> inputs);

/// Throws NotConverged if the accuracy ordered was missed, after the best result has been written.
void require_target(const BakeResult& result);

/// Sites are placed where they help, unless the command line says whether they are, gives their spacing, asks for few
/// of them, a draft, an accuracy or a transport for any light, or chooses what has no such sites.
void grade_by_default(const BakeArguments& arguments, const Registry& registry, BakeOptions& options);

/// The options, with what --quality chooses for those that are not given, the points of --at and the goals of --goal
/// read, and the files of the bake as outputs. Throws what reading them throws, and UsageError for --rays beside
/// directions that state their number.
BakeOptions bake_options(const BakeArguments& arguments, const Registry& registry);

} // namespace difusa
