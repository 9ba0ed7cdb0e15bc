// render_view scene out: bakes a scene, or lights a saved transport, and makes pictures of it, without a display.
// Parses options, bakes, writes pictures.
#include "bake_arguments.h"
#include "run_bake.h"
#include "terminal.h"

#include <difusa/bake.h>
#include <difusa/core/text.h>
#include <difusa/io/image_files.h>
#include <difusa/io/whole_file.h>
#include <difusa/output/bake_files.h>
#include <difusa/render/picture.h>
#include <difusa/render/place_camera.h>
#include <difusa/repair/findings.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace render_view {

using difusa::add_parsed;
using difusa::ExitCode;
using difusa::UsageError;

const char* const examples =
    R"(Bakes a scene as bake_radiosity does, and makes pictures of it by ray casting; no display is needed.

Examples:
  render_view scene.json out.png
      seen by the file's camera; without one, an object from outside as a whole, a closed room from inside
  render_view room.obj out.png --eye 0.3,0.3,-0.8 --look-at 0.3,0.3,0.3 --final-gather 256
      from a given position, accurate
  render_view room.obj out.png --also direct=direct.png --also luminance=luminance.png --also sites=sites.png
      several pictures of one bake
  render_view room.obj basis.png --show basis --element 42 --sites 500
      one basis element
  render_view house.off out.hdr --sky 1 --cull-backs
      linear radiances; seeing through the backs of walls
  render_view room.difusa out.png --eye 0.3,0.3,-0.8
      of a transport saved by bake_radiosity --save-transport: other views, without baking again

What can be shown: radiosity; its parts direct and indirect; irradiance, irradiance-direct, irradiance-indirect,
emission (W/m^2); reflectance; group:NAME, the radiosity of one light group; luminance (cd/m^2), illuminance (lux),
radiosity-weighted, irradiance-weighted (W/m^2, weighted by luminance), error (of the radiosity, estimated, W/m^2),
illuminance-error (lux), basis, in false colours with a colour bar; sites, as dots. Back faces are dark grey. Of
thermal scenes: temperature (K, the default), net-flux, radiosity-weighted, irradiance-weighted (W/m^2, not weighted),
error, basis, sites. An .hdr holds these numbers; but radiosity, its parts and emission as radiances, W/(m^2 sr), which
are the radiosity over pi.

Exit codes: 0 done, 1 usage, 2 input, 3 not converged or --error not reached, 4 resources, 5 internal, 130 interrupted.
)";

/// A picture to make.
struct Picture {
    difusa::Show show;
    std::string name; ///< name of what it shows, as typed
    std::filesystem::path file;
};

/// What is shown where rays hit nothing.
struct Background {
    std::optional<difusa::Rgb> colour; ///< absent: the sky
};

struct Arguments {
    std::filesystem::path mesh, out;
    std::string show = "radiosity";
    std::vector<Picture> also;
    difusa::BakeArguments bake;
    difusa::RunArguments run;
    difusa::CameraWishes camera;
    difusa::ViewOptions view;
    std::vector<std::size_t> size;
    std::optional<double> exposure; ///< absent: auto
    difusa::ToneCurve tone = difusa::ToneCurve::filmic;
    std::optional<Background> background;
    std::optional<std::pair<double, double>> range;
    std::optional<difusa::Index> element;
    std::optional<difusa::Vec3> near;
    bool logarithmic = false;
};

difusa::Vec3 parse_direction(const std::string& option, const std::string& text) {
    const difusa::Vec3 direction = difusa::parse_point(option, text);
    if (!(direction.stableNorm() > 0.0)) {
        throw UsageError(option + " " + text + ": must be a nonzero direction");
    }
    return direction;
}

double parse_degrees(const std::string& option, const std::string& text) {
    const double degrees = difusa::parse_positive(option, text);
    if (!(degrees < 180.0)) {
        throw UsageError(option + " " + text + ": must be below 180");
    }
    return degrees * std::numbers::pi / 180.0;
}

std::pair<double, double> parse_range(const std::string& option, const std::string& text) {
    const auto values = difusa::parse_numbers(text);
    if (!values || values->size() != 2 || !((*values)[0] < (*values)[1])) {
        throw UsageError(option + " " + text + ": takes LOW,HIGH with LOW below HIGH");
    }
    return {(*values)[0], (*values)[1]};
}

Background parse_background(const std::string& option, const std::string& text) {
    if (text == "sky") {
        return {};
    }
    const difusa::Rgb colour = difusa::parse_rgb(option, text);
    if (!(colour <= 1.0).all()) {
        throw UsageError(option + " " + text + ": must be from 0 to 1 in each channel, or sky");
    }
    return {colour};
}

std::optional<double> parse_exposure(const std::string& option, const std::string& text) {
    return text == "auto" ? std::nullopt : std::optional(difusa::parse_positive(option, text));
}

difusa::ToneCurve parse_tone(const std::string& option, const std::string& text) {
    if (text != "linear" && text != "filmic") {
        throw UsageError(option + " " + text + ": must be linear or filmic");
    }
    return text == "linear" ? difusa::ToneCurve::linear : difusa::ToneCurve::filmic;
}

Picture parse_also(const std::string& option, const std::string& text) {
    const std::size_t sign = text.find('=');
    if (sign == std::string::npos || sign == 0 || sign + 1 == text.size()) {
        throw UsageError(option + " " + text + ": takes SHOW=FILE, such as direct=direct.png");
    }
    return {difusa::parse_show(text.substr(0, sign)), text.substr(0, sign), text.substr(sign + 1)};
}

void declare_camera(CLI::App& app, Arguments& a) {
    const std::string group = "Camera (default: the scene file's, or the whole from outside, or a room from a corner)";
    add_parsed(app, "--eye", a.camera.eye, "position, in metres for a scene file", difusa::parse_point)
        ->group(group)
        ->type_name("X,Y,Z");
    add_parsed(app, "--look-at", a.camera.look_at, "point in the middle of the picture", difusa::parse_point)
        ->group(group)
        ->type_name("X,Y,Z");
    add_parsed(app, "--towards", a.camera.towards, "viewing direction, instead of --look-at", parse_direction)
        ->group(group)
        ->type_name("X,Y,Z");
    add_parsed(
        app, "--up", a.camera.up,
        "up direction in the picture (default: what the scene file says; y for glTF and OBJ, z for others, unless "
        "there is a floor along the other of the two)",
        parse_direction)
        ->group(group)
        ->type_name("X,Y,Z");
    add_parsed(app, "--view-angle", a.camera.view_angle, "vertical field of view in degrees", parse_degrees)
        ->group(group)
        ->type_name("DEGREES");
}

void declare_picture(CLI::App& app, Arguments& a) {
    const std::string group = "Picture";
    app.add_option("--show", a.show, "what the picture shows, see above")
        ->group(group)
        ->type_name("NAME")
        ->capture_default_str();
    difusa::add_repeated(app, "--also", a.also, "additional picture of the same bake (may be repeated)", parse_also)
        ->group(group)
        ->type_name("SHOW=FILE");
    difusa::add_repeated(app, "--size", a.size, "width and height in pixels, without the colour bar (default: 800 600)",
                         [](const std::string& option, const std::string& text) {
                             return difusa::parse_whole<std::size_t>(option, text, 1);
                         })
        ->group(group)
        ->type_name("W H")
        ->expected(2);
    difusa::add_whole<std::size_t>(app, "--samples", a.view.samples, 1, "rays through each pixel: 1, 4, 9, 16, ...")
        ->group(group)
        ->type_name("N")
        ->default_str(difusa::shown(a.view.samples));
    difusa::add_whole<std::size_t>(app, "--glossy-rays", a.view.glossy_rays, 1,
                                   "rays that go on where a ray through a pixel meets a glossy surface")
        ->group(group)
        ->type_name("N")
        ->default_str(difusa::shown(a.view.glossy_rays));
    app.add_flag("--cull-backs", a.view.cull_backs, "see through back faces")->group(group);
    add_parsed(
        app, "--background", a.background,
        "where rays hit nothing: a linear colour, 0 to 1, shown as is, or sky (default: the sky if it is an image or a "
        "gradient, else a neutral grey)",
        parse_background)
        ->group(group)
        ->type_name("R[,G,B] or sky");
    add_parsed(app, "--exposure", a.exposure,
               "factor applied to light before display, or auto: 95 % of what the first picture of light shows "
               "is at most 0.9 (default: auto)",
               parse_exposure)
        ->group(group)
        ->type_name("E");
    add_parsed(app, "--tone", a.tone, "linear, clipped at 1, or filmic, which approaches 1 gradually", parse_tone)
        ->group(group)
        ->type_name("NAME")
        ->default_str("filmic");
    add_parsed(app, "--element", a.element, "the element that --show basis shows (default: the sum of all)",
               [](const std::string& option, const std::string& text) {
                   return difusa::parse_whole<difusa::Index>(option, text, 0);
               })
        ->group(group)
        ->type_name("I");
    add_parsed(app, "--near", a.near, "the element whose site is nearest to a point, instead of --element",
               difusa::parse_point)
        ->group(group)
        ->type_name("X,Y,Z");
    add_parsed(app, "--range", a.range,
               "values at the ends of the colour bar (default: the first and last percentile of what is seen)",
               parse_range)
        ->group(group)
        ->type_name("LOW,HIGH");
    app.add_flag("--log", a.logarithmic, "logarithmic colour bar")->group(group);
}

void declare(CLI::App& app, Arguments& a) {
    app.add_option("scene", a.mesh, std::string(difusa::mesh_help) + ", or a transport saved by bake_radiosity")
        ->type_name("SCENE");
    app.add_option("out", a.out, "picture: .png, or .hdr (Radiance: linear, without colour maps)")->type_name("OUT");
    declare_picture(app, a);
    declare_camera(app, a);
    add_bake_arguments(app, a.bake, "each sample");
    add_run_arguments(app, a.run, a.bake.options.seed, "the result does not depend");
}

/// Throws UsageError for what a Radiance picture cannot hold: it has no negative values.
void check_linear(const Picture& picture) {
    const difusa::Quantity shown = picture.show.quantity;
    const std::string show = "--show " + picture.name + " in " + picture.file.string() + ": ";
    if (shown == difusa::Quantity::sites) {
        throw UsageError(show + "the dots are drawn in .png pictures only");
    }
    if (shown == difusa::Quantity::net_flux || shown == difusa::Quantity::basis) {
        throw UsageError(show + "there are negative values, which .hdr pictures cannot hold: give a .png" +
                         (shown == difusa::Quantity::net_flux ? ", or bake a .vtp, which has net_flux" : ""));
    }
}

/// All pictures, the first one first. Rejects contradictory options.
std::vector<Picture> pictures_of(const Arguments& a) {
    if (a.mesh.empty()) {
        throw UsageError("a scene or mesh file is expected: render_view scene.json out.png (--help)");
    }
    if (a.out.empty()) {
        throw UsageError("a picture file is expected: render_view " + a.mesh.string() + " out.png (--help)");
    }
    std::vector<Picture> pictures{{difusa::parse_show(a.show), a.show, a.out}};
    pictures.insert(pictures.end(), a.also.begin(), a.also.end());
    bool basis = false, mapped = false, exposed = false;
    std::vector<difusa::OutputName> outputs;
    for (const Picture& picture : pictures) {
        const bool linear = difusa::is_radiance_hdr(picture.file); // or rejects its name
        if (linear) {
            check_linear(picture);
        }
        exposed = exposed || (!linear && colouring_of(picture.show.quantity) == difusa::Colouring::light);
        outputs.push_back({picture.file, false});
        mapped = mapped || colouring_of(picture.show.quantity) == difusa::Colouring::map;
        basis = basis || picture.show.quantity == difusa::Quantity::basis;
    }
    if ((a.element || a.near) && !basis) {
        throw UsageError(std::string(a.element ? "--element" : "--near") + ": only valid with --show basis");
    }
    if (a.element && a.near) {
        throw UsageError("--element and --near both choose the element to show: give only one of them");
    }
    if ((a.range || a.logarithmic) && !mapped) {
        throw UsageError(std::string(a.range ? "--range" : "--log") +
                         ": no picture has a colour bar; show luminance, illuminance, error or basis");
    }
    for (const char* const option : {"--exposure", "--tone"}) {
        if (!exposed && a.bake.given(option)) {
            throw UsageError(std::string(option) + ": no picture is exposed: .hdr pictures are linear, and those with "
                                                   "a colour bar have a --range");
        }
    }
    if (a.range && a.logarithmic && !(a.range->first > 0.0)) {
        throw UsageError("--range: must begin above 0 with --log");
    }
    if (a.camera.look_at && a.camera.towards) {
        throw UsageError("--look-at and --towards both say where the camera looks: give only one of them");
    }
    check_bake_outputs(a.bake, outputs, {{a.mesh, "the scene"}});
    return pictures;
}

/// Pictures of the basis show the requested element, if there is one.
void choose_element(const Arguments& a, const difusa::SiteSet& sites, std::vector<difusa::Show>& shows) {
    std::optional<difusa::Index> element = a.element;
    if (a.near) {
        const auto nearest =
            std::min_element(sites.points.begin(), sites.points.end(), [&](const auto& p, const auto& q) {
                return (p.position - *a.near).squaredNorm() < (q.position - *a.near).squaredNorm();
            });
        element = static_cast<difusa::Index>(nearest - sites.points.begin());
    }
    for (difusa::Show& show : shows) {
        if (show.quantity == difusa::Quantity::basis && element) {
            show.element = element;
            show.title = "element " + std::to_string(*element);
        }
    }
}

struct Developed {
    std::string content; ///< of the file
    std::size_t width = 0, height = 0;
};

/// Sets `how` to the exposure or range that the picture was made with.
Developed developed(const difusa::BakeResult& result, const difusa::View& view, std::size_t show, const Arguments& a,
                    const std::filesystem::path& file, double exposure, std::string& how,
                    const difusa::Execution& execution) {
    if (difusa::is_radiance_hdr(file)) {
        how = ", linear";
        const std::optional<difusa::Rgb> background = a.background ? a.background->colour : std::nullopt;
        return {radiance_hdr_of(linear_picture(view, show, background, execution)), a.view.width, a.view.height};
    }
    difusa::Development development{exposure, a.tone, {}, {}, false};
    if (a.background) {
        development.background = a.background->colour;
    }
    development.sky = a.background ? !a.background->colour : result.scene->dome != nullptr && !result.sky_assumed;
    switch (colouring_of(view.shows[show].quantity)) {
    case difusa::Colouring::light:
        how = ", exposure " + difusa::text_of(exposure);
        break;
    case difusa::Colouring::map:
        development.scale = a.range ? difusa::ColourScale{a.range->first, a.range->second, a.logarithmic}
                                    : scale_of(view, show, a.logarithmic);
        how = (view.shows[show].element ? ", " + view.shows[show].title : "") + ", " +
              difusa::text_of(development.scale.low) + " to " + difusa::text_of(development.scale.high);
        break;
    default:
        break;
    }
    const difusa::Image image = develop(result, view, show, development, execution);
    return {png_of(image), image.width, image.height};
}

/// The common exposure of all pictures of light.
double exposure_for(const Arguments& a, const difusa::View& view) {
    for (std::size_t k = 0; k < view.shows.size() && !a.exposure; ++k) {
        if (colouring_of(view.shows[k].quantity) == difusa::Colouring::light) {
            return exposure_of(view, k);
        }
    }
    return a.exposure.value_or(1.0);
}

/// Pictures of the light that surfaces send out, of which they send none.
bool exposes_nothing(const difusa::BakeResult& result, const difusa::View& view) {
    const difusa::Mesh& mesh = result.scene->mesh;
    return !result.scene->has_emitters() && !result.scene->thermal && !mesh.mirrors.any() && !mesh.glossy.any() &&
           difusa::largest_reflectance(*result.scene, result.channels) == 0.0 &&
           std::any_of(view.shows.begin(), view.shows.end(),
                       [](const difusa::Show& show) { return show.quantity == difusa::Quantity::radiosity; });
}

/// Refuses a picture of nothing before the work; what there is to note about one of back faces, or nothing.
std::string check_view_of(const difusa::Mesh& mesh, const difusa::Camera& camera, const difusa::Coverage& coverage,
                          const Arguments& a) {
    if (coverage.fronts + coverage.backs == 0.0) {
        throw UsageError("the picture would show nothing: from " + difusa::coordinates(camera.eye) + " towards " +
                         difusa::coordinates(camera.towards) + ", no ray meets the surface, which lies between " +
                         difusa::coordinates(mesh.low) + " and " + difusa::coordinates(mesh.high) +
                         "; change --eye, --look-at or --towards, or omit them for a view of the whole");
    }
    if (!a.camera.cull_backs && coverage.fronts < 0.1 * coverage.backs) {
        return "the picture shows mostly back faces, in dark grey: look from another side, see through them with "
               "--cull-backs, or turn them over with --flip all";
    }
    return "";
}

/// A saved transport has its sites, rays and projection.
void refuse_choices_of_transport(const Arguments& a) {
    for (const char* option : {"--quality", "--basis", "--sampler", "--spacing", "--sites", "--neighbours",
                               "--adaptive", "--levels", "--projection", "--transport", "--rays", "--directions",
                               "--kernel", "--mirror-depth", "--flip", "--error", "--seed"}) {
        if (a.bake.given(option)) {
            throw UsageError(std::string(option) + ": " + a.mesh.string() +
                             " is a saved transport, for which this was decided when it was baked; omit the option, or "
                             "name the scene");
        }
    }
}

/// The bake, or the saved one in its own light and that of the options.
difusa::BakeResult baked(const Arguments& a, bool saved, const difusa::Registry& registry,
                         const difusa::BakeOptions& options, const difusa::Execution& execution) {
    if (!saved) {
        return difusa::bake(registry, a.mesh, options, execution);
    }
    difusa::RelightOptions how;
    how.bake = options;
    return with_transport(a.mesh, a.bake, how, execution, [&](const difusa::SavedTransport& transport) {
        return difusa::relight(registry, transport, how, execution);
    });
}

void run(Arguments& a) {
    const difusa::Registry registry = difusa::Registry::load(a.run.plugin_path);
    std::vector<Picture> pictures = pictures_of(a);
    const bool saved = difusa::is_transport_file(a.mesh);
    if (saved) {
        refuse_choices_of_transport(a);
    }
    difusa::BakeOptions options = bake_options(a.bake, registry);
    if (!saved) {
        grade_by_default(a.bake, registry, options);
    }
    if (a.size.size() == 2) {
        a.view.width = a.size[0];
        a.view.height = a.size[1];
    }
    a.view.final_gather = options.final_gather;
    a.camera.cull_backs = a.view.cull_backs;
    check_view(a.view);
    options.graded_sky = !saved;                                 // the picture is that of the result which was saved
    options.output_spacing = std::numeric_limits<double>::max(); // the pictures are the output, not the mesh
    std::vector<difusa::Show> shows;
    for (const Picture& picture : pictures) {
        shows.push_back(picture.show);
        options.outputs.push_back(picture.file);
        options.light_groups = options.light_groups || picture.show.quantity == difusa::Quantity::group;
    }

    difusa::TerminalProgress progress(a.run.quiet);
    const difusa::Execution execution = a.run.execution(progress);
    std::string note;
    options.when_visible = [&](const difusa::Scene& scene, const difusa::Visibility& visibility,
                               const std::optional<difusa::Camera>& of_scene, const difusa::Vec3& up) {
        const double aspect = static_cast<double>(a.view.width) / static_cast<double>(a.view.height);
        if (scene.thermal && !a.bake.given("--show")) {
            shows.front() = difusa::parse_show("temperature");
            pictures.front().name = "temperature";
        }
        check_shows(scene, shows);
        a.view.camera = place_camera(a.camera, of_scene, up, scene.mesh, visibility, aspect);
        note = check_view_of(scene.mesh, a.view.camera, coverage_of(a.view.camera, visibility, aspect), a);
    };
    difusa::BakeResult result;
    difusa::View view;
    progress.watch([&] {
        result = baked(a, saved, registry, options, execution);
        a.view.seed = result.options.seed;
        execution.phase("trace picture");
        choose_element(a, *result.sites, shows);
        view = look(result, a.view, shows, execution);
    });

    if (!note.empty()) {
        result.journal.note(note);
    }
    if (exposes_nothing(result, view)) {
        result.journal.note(
            "nothing reflects or emits light, so that its radiosity is black: --show illuminance for the "
            "light that arrives");
    }
    execution.phase("write pictures");
    const double exposure = exposure_for(a, view);
    std::vector<std::unique_ptr<difusa::WholeFile>> files;
    std::string written;
    for (std::size_t k = 0; k < pictures.size(); ++k) {
        std::string how;
        const Developed picture = developed(result, view, k, a, pictures[k].file, exposure, how, execution);
        files.push_back(std::make_unique<difusa::WholeFile>(pictures[k].file));
        files.back()->write(picture.content);
        written += "written: " + pictures[k].file.string() + " (" + std::to_string(picture.width) + " by " +
                   std::to_string(picture.height) + ", " + pictures[k].name + how + ")\n";
    }
    difusa::write_bake(result, a.bake.files, execution);
    for (const auto& file : files) {
        file->commit();
    }
    progress.clear();
    if (!a.run.quiet) {
        std::cout << difusa::summary_of(result) << "pictures: " << view.rays << " rays and " << view.segments
                  << " segments, not counting those through the pixels\n"
                  << written;
        for (const std::filesystem::path& file : a.bake.files.beside_field()) {
            std::cout << "written: " << file.string() << "\n";
        }
    }
    require_target(result);
}

int program(int count, char** words) {
    Arguments arguments;
    CLI::App app(examples, "render_view");
    declare(app, arguments);
    return difusa::run_command(app, count, words, "one scene and one picture", arguments.run.version,
                               [&] { run(arguments); });
}

} // namespace render_view
