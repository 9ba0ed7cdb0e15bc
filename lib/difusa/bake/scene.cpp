#include <difusa/bake/scene.h>

#include <difusa/bake/thermal.h>
#include <difusa/core/error.h>
#include <difusa/core/text.h>
#include <difusa/import/scene_file.h>
#include <difusa/io/same_file.h>
#include <difusa/mesh/floor_share.h>
#include <difusa/repair/diagnosis.h>
#include <difusa/repair/findings.h>
#include <difusa/repair/texture_coordinates.h>
#include <difusa/scene/light_symmetry.h>
#include <difusa/scene/sky_dome.h>
#include <difusa/scene/sound_scene.h>

#include <algorithm>
#include <memory>
#include <numbers>

namespace difusa {

namespace {

/// The fourth power of a distance between sites, in form factors, must not underflow.
constexpr double least_diameter = 1e-60;

void check_size(const Mesh& mesh, const std::string& name) {
    if (!(mesh.diameter() >= least_diameter)) {
        throw InputError(name + ": the scene is " + text_of(mesh.diameter()) +
                         " across, too small for double precision: use a smaller unit of length");
    }
}

/// Rejects a scene built by a program that would not have passed when read from a file.
void check_scene(const Scene& scene, const std::string& name) {
    const auto refuse = [&](const std::string& why) { throw InputError(name + ": " + why); };
    const Mesh& mesh = scene.mesh;
    const std::size_t count = mesh.triangles.size();
    if (count == 0 || mesh.normals.size() != count || mesh.material.size() != count ||
        mesh.original_face.size() != count) {
        refuse("the mesh is empty, not derived (Mesh::derive), or lacks a material or an original face for some "
               "triangle");
    }
    if (!mesh.is_derived()) {
        refuse("the mesh is not what was derived: call Mesh::derive after every change to its points or triangles");
    }
    if (!mesh.corner_reflectance.empty() && mesh.corner_reflectance.size() != mesh.triangles.size()) {
        refuse("there are vertex colours of " + std::to_string(mesh.corner_reflectance.size()) + " triangles, but " +
               std::to_string(mesh.triangles.size()) + " triangles");
    }
    check_size(mesh, name);
    for (const Index material : mesh.material) {
        if (material >= scene.materials.size()) {
            refuse("a triangle has material number " + std::to_string(material) + " of " +
                   std::to_string(scene.materials.size()));
        }
        if (is_textured(scene.materials[material]) && mesh.corner_texture.size() != mesh.triangles.size()) {
            refuse(name_of(scene, material) + " has a texture, but some triangles have no texture coordinates");
        }
        if (scene.materials[material].vertex_colours && mesh.corner_reflectance.size() != mesh.triangles.size()) {
            refuse(name_of(scene, material) + " uses vertex colours, but some triangles have none");
        }
    }
    check_materials_and_lights(scene, name);
}

/// Three times as bright at the zenith as at the horizon h, and half as bright below, so that shapes show under it.
/// From the radiance (1 + 2 s) h at the sine s of the elevation, a level surface receives pi h (1 + 4 / 3).
std::shared_ptr<const SkyDome> graded_sky(const Vec3& up) {
    const double horizon = 3.0 / (7.0 * std::numbers::pi);
    return std::make_shared<GradientSky>(Rgb::Constant(3.0 * horizon), Rgb::Constant(horizon),
                                         Rgb::Constant(0.5 * horizon), up);
}

/// Rejects light so strong or weak that squares of its errors would leave the range of doubles.
void check_levels(const Scene& scene, const std::string& name) {
    const auto check = [&](const std::string& what, const Rgb& light) {
        if (!is_light(light)) {
            throw InputError(name + ": " + what + " is " + text_of(light) +
                             ": lights must be 0, or from 1e-100 to 1e100; use another unit of power");
        }
    };
    check("the irradiance of the sky", scene.sky);
    for (const Sun& sun : scene.suns) {
        check("the irradiance of a sun", sun.irradiance);
    }
    for (const PointLight& light : scene.point_lights) {
        check("the intensity of the light at " + coordinates(light.position), light.intensity);
    }
    const std::vector<char> used = scene.used_materials();
    for (std::size_t m = 0; m < used.size(); ++m) {
        if (used[m] != 0) {
            check("the emission of the material " + scene.materials[m].name, scene.materials[m].emission);
        }
    }
}

/// Adds the lights from the options, and a sky if there would be none at all. A scene whose lights are all dark is
/// refused; `states_sky`: they include a sky.
void add_lights(BakeResult& result, bool states_sky, const Execution& execution) {
    Scene& scene = *result.scene;
    BakeOptions& options = result.options;
    if (is_thermal(scene)) {
        make_thermal(result, execution);
        return;
    }
    add_chosen_lights(scene, options);
    if (!result.light_factors.empty()) {
        const bool was_lit = has_light(scene);
        scale_lights(result.light_factors, scene);
        result.turned_off = result.turned_off || (was_lit && !has_light(scene));
    }
    check_levels(scene, result.file);
    const bool lit = has_light(scene) || result.turned_off;
    if (!lit && (options.sky || states_sky || !scene.suns.empty() || !scene.point_lights.empty())) {
        throw InputError(result.file + ": all lights of the scene are dark: give it a sky (--sky 1), a sun "
                                       "(--sun 0,0,1,1), or some faces an emission (OBJ: Ke in the material)");
    }
    if (!lit) {
        assume_sky(result, scene, execution);
    }
    try {
        check_light_symmetry(scene);
    } catch (const InputError& error) {
        throw InputError(result.file + ": " + error.what());
    }
    options.sky = scene.sky;
    result.channels = scene.is_grey() ? 1 : 3;
}

/// Settles what of the surface follows from the scene as a whole.
void settle_surface(BakeResult& result, const Execution& execution) {
    Scene& scene = *result.scene;
    if (!result.options.gloss) {
        std::size_t count = 0;
        for (Material& material : scene.materials) {
            count += material.gloss ? 1 : 0;
            material.gloss.reset();
        }
        if (count > 0) {
            execution.note("what " + std::to_string(count) +
                           (count == 1 ? " glossy material reflects" : " glossy materials reflect") +
                           " in a lobe is absorbed (--no-gloss)");
        }
    }
    settle_mirrors(scene, result.options.mirror_depth);
    settle_gloss(scene);
    try {
        settle_repetition(scene.mesh, [&](Index face) { return face_name(result.diagnosis, face); });
    } catch (const InputError& error) {
        throw InputError(result.file + ": " + error.what());
    }
    if (scene.mesh.repetition.any() && scene.mesh.mirrors.any()) {
        throw InputError(result.file + ": has mirrors, and symmetry planes or periods: what is seen in mirrors is not "
                                       "followed beyond these; remove one of them");
    }
    if (scene.mesh.glossy.any() && (scene.mesh.repetition.any() || scene.mesh.mirrors.any() || is_thermal(scene))) {
        throw InputError(result.file + ": has glossy materials, which are not computed together with mirrors, symmetry "
                                       "planes, periods or temperatures: remove one of them, or use --no-gloss");
    }
}

/// Upwards: what the file says; else the axis along which the scene has a floor, if there is just one among y and z;
/// else what is usual in files of this format.
Vec3 up_of(const PolygonSoup& soup, const Mesh& mesh, const Execution& execution) {
    constexpr double whole = 0.5; // of the scene's footprint: a floor, or most of one under furniture
    const bool y = floor_share(mesh, Vec3::UnitY()) > whole, z = floor_share(mesh, Vec3::UnitZ()) > whole;
    const Vec3 floored = y ? Vec3::UnitY() : Vec3::UnitZ();
    if (soup.says_up || y == z || floored == soup.up) {
        return soup.up;
    }
    execution.note(std::string("the file does not say which way is up: its floor says ") + (y ? "+y" : "+z") +
                   " (--up of render_view)");
    return floored;
}

/// Gives faces without a material the default one, or one using the colours in the file, and likewise those whose
/// material has a name alone.
void add_default_material(BakeResult& result, const PolygonSoup& soup, const Execution& execution) {
    Scene& scene = *result.scene;
    const auto number = static_cast<Index>(soup.materials.size());
    const std::vector<Index>& used = scene.mesh.material;
    Material material;
    material.reflectance = result.options.reflectance.value_or(material.reflectance);
    material.vertex_colours = soup.faces_are_painted();
    bool any = std::find(used.begin(), used.end(), number) != used.end();
    if (any) {
        scene.materials.push_back(material);
        scene.materials.back().name = material.vertex_colours ? "vertex colours" : "default";
    }
    for (Index m = 0; m < number; ++m) {
        if (Material& undefined = scene.materials[m]; undefined.is_undefined) {
            undefined.reflectance = material.reflectance;
            undefined.vertex_colours = material.vertex_colours;
            any = any || std::find(used.begin(), used.end(), m) != used.end();
        }
    }
    if (!any) {
        return;
    }
    result.options.reflectance = material.reflectance;
    if (!material.vertex_colours) {
        execution.note("faces without a colour have the reflectance " + text_of(material.reflectance) +
                       " (--reflectance)");
    }
}

} // namespace

void add_chosen_lights(Scene& scene, const BakeOptions& options) {
    if (options.sky) {
        std::erase_if(scene.suns, [](const Sun& sun) { return sun.of_sky; });
        scene.sky = *options.sky;
        scene.dome = nullptr;
    }
    scene.suns.insert(scene.suns.end(), options.suns.begin(), options.suns.end());
    scene.point_lights.insert(scene.point_lights.end(), options.point_lights.begin(), options.point_lights.end());
}

void assume_sky(BakeResult& result, Scene& scene, const Execution& execution) {
    result.sky_assumed = true;
    if (result.options.graded_sky) {
        scene.dome = graded_sky(result.up);
        execution.note("nothing emits light: a sky is assumed that is bright above and dim below, of irradiance 1 "
                       "W/m^2 on a surface that faces up (--sky)");
    } else {
        scene.sky = Rgb::Ones();
        execution.note("nothing emits light: a uniform sky of irradiance 1 W/m^2 is assumed (--sky)");
    }
}

bool has_light(const Scene& scene) {
    return scene.has_sky() || scene.has_emitters() ||
           std::any_of(scene.suns.begin(), scene.suns.end(),
                       [](const Sun& sun) { return (sun.irradiance > 0.0).any(); }) ||
           std::any_of(scene.point_lights.begin(), scene.point_lights.end(),
                       [](const PointLight& light) { return (light.intensity > 0.0).any(); });
}

PolygonSoup read_apart_from(const std::vector<std::filesystem::path>& outputs, const Registry& registry,
                            const std::filesystem::path& file) {
    PolygonSoup soup = read_scene(registry, file);
    refuse_to_overwrite(soup.files, outputs);
    refuse_to_overwrite(registry.files(), outputs);
    return soup;
}

void read_into(BakeResult& result, const Registry& registry, const std::filesystem::path& file,
               const Execution& execution, const SceneChange& change) {
    execution.phase("read");
    result.file = file.string();
    const PolygonSoup soup = read_apart_from(result.options.outputs, registry, file);
    result.files = soup.files;
    execution.phase("check mesh");
    DiagnosedMesh diagnosed = diagnose(soup, execution);
    result.diagnosis = std::move(diagnosed.diagnosis);
    for (const std::string& what : soup.notes) {
        execution.note(what);
    }
    for (const Finding& finding : result.diagnosis.findings) {
        if (finding.repaired && execution.progress != nullptr) {
            execution.progress->remark(finding.message());
        }
    }
    result.scene = std::make_shared<Scene>();
    Scene& scene = *result.scene;
    scene.mesh = std::move(diagnosed.mesh);
    check_size(scene.mesh, result.file);
    scene.materials = soup.materials;
    scene.suns = soup.lights.suns;
    scene.point_lights = soup.lights.points;
    scene.sky = soup.lights.sky.value_or(Rgb::Zero());
    scene.dome = soup.lights.dome;
    if (soup.surroundings) {
        scene.thermal = ThermalSetting{soup.surroundings};
    }
    result.camera = soup.camera;
    result.photometric_lights = soup.photometric;
    result.photometric = result.photometric || (result.options.units == "auto" && soup.photometric);
    result.up = up_of(soup, scene.mesh, execution);
    if (soup.default_reflectance && !result.options.reflectance) {
        result.options.reflectance = soup.default_reflectance;
    }
    add_default_material(result, soup, execution);
    scene.mesh.repetition = soup.repetition;
    if (change) {
        change(scene);
    }
    settle_surface(result, execution);
    add_lights(result, soup.lights.sky.has_value(), execution);
}

void adopt_into(BakeResult& result, Scene scene, const std::string& name, const Execution& execution,
                const SceneChange& change) {
    result.file = name;
    result.diagnosis.file_faces = scene.mesh.triangles.size();
    result.diagnosis.file_points = scene.mesh.points.size();
    check_scene(scene, name);
    result.scene = std::make_shared<Scene>(std::move(scene));
    if (change) {
        change(*result.scene);
    }
    settle_surface(result, execution);
    add_lights(result, false, execution);
}

} // namespace difusa
