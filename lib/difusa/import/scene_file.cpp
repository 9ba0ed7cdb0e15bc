#include <difusa/import/scene_file.h>

#include <difusa/core/error.h>
#include <difusa/core/text.h>
#include <difusa/import/file_content.h>
#include <difusa/import/json_tree.h>
#include <difusa/import/placement.h>
#include <difusa/import/reader.h>
#include <difusa/import/text_scanner.h>
#include <difusa/import/texture_files.h>
#include <difusa/plugin/parameters.h>
#include <difusa/repair/soup_check.h>
#include <difusa/repair/texture_coordinates.h>
#include <difusa/scene/sky_dome.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

namespace difusa {

namespace {

/// Rays find what is left of a bright spot with a noise of limit times the root of the part of all rays that meet it,
/// which is 1/300 for the largest that is taken for a sun (0.01 sr of pi). With 10 that is 0.6, where half a sky that
/// is hidden gives 0.5.
constexpr double sun_limit = 10.0;
constexpr std::size_t most_suns = 16; ///< of a sky's image: each costs a shadow ray wherever light is looked for

std::string quoted(const std::string& name) {
    return "\"" + name + "\"";
}

/// The message where not one of two members is given, but `both` or none.
std::string either_or(const std::string& what, const std::string& one, const std::string& other, bool both) {
    return both ? what + " has both " + one + " and " + other + ", of which only one may be given: remove one"
                : what + " needs either " + one + " or " + other + ": add one";
}

class SceneFile {
  public:
    SceneFile(const std::filesystem::path& name, const MeshSource& meshes)
        : checks_(name.string()), folder_(name.parent_path()), read_mesh_(meshes) {
        soup_.file = name.string();
    }

    PolygonSoup read(std::string_view content) {
        const JsonValue root = parse_json(content, checks_.file());
        checks_.object(root, "a scene file");
        if (root.find("difusa_scene") == nullptr) {
            checks_.fail(root, "this JSON file is no scene of difusa: those begin with \"difusa_scene\": 1");
        }
        if (const JsonValue& version = *root.find("difusa_scene"); version.number != 1.0) {
            checks_.fail(version, "\"difusa_scene\" is the version of the format, and must be 1");
        }
        checks_.members(root, "a scene",
                        {"difusa_scene", "unit", "up", "meshes", "materials", "lights", "sky", "camera", "defaults"});
        unit_ = unit(root, 1.0);
        if (const JsonValue* up = root.find("up")) {
            up_ = up_direction(*up);
        }
        if (const JsonValue* defaults = root.find("defaults")) {
            checks_.members(*defaults, quoted("defaults"), {"reflectance"});
            if (const JsonValue* reflectance = defaults->find("reflectance")) {
                soup_.default_reflectance = reflectance_of(*reflectance);
            }
        }
        if (const JsonValue* materials = root.find("materials")) {
            read_materials(*materials);
        }
        if (const JsonValue* lights = root.find("lights")) {
            for (const JsonValue& light : checks_.list(*lights, quoted("lights"))) {
                read_light(light);
            }
        }
        if (const JsonValue* sky = root.find("sky")) {
            read_sky(*sky);
        }
        if (const JsonValue* camera = root.find("camera")) {
            soup_.camera = camera_of(*camera);
        }
        const JsonValue& meshes = checks_.required(root, "a scene", "meshes");
        if (checks_.list(meshes, quoted("meshes")).empty()) {
            checks_.fail(meshes, "a scene needs a mesh: add {\"file\": ...} to \"meshes\"");
        }
        for (const JsonValue& mesh : meshes.items) {
            read_mesh(mesh);
        }
        soup_.notes.insert(soup_.notes.end(), textures_.notes().begin(), textures_.notes().end());
        settle_textures(soup_);
        return std::move(soup_);
    }

  private:
    // ---- values -----------------------------------------------------------------------------------------------

    /// One number, or R G B; none negative.
    Rgb colour(const JsonValue& value, const std::string& what) const {
        Rgb c;
        if (value.kind == JsonValue::Kind::number) {
            c = Rgb::Constant(checks_.number(value, what));
        } else if (value.kind == JsonValue::Kind::list && value.items.size() == 3) {
            c = Rgb(checks_.vector(value, what).array());
        } else {
            checks_.fail(value, what + " must be a number (grey) or a list [r, g, b]");
        }
        if (!(c >= 0.0).all() || !(c <= 1e30).all()) {
            checks_.fail(value, what + " must be from 0 to 1e30 in each channel");
        }
        return c;
    }

    Rgb reflectance_of(const JsonValue& value) const {
        const Rgb rho = colour(value, quoted("reflectance"));
        if (!(rho <= 1.0).all()) {
            checks_.fail(value, "\"reflectance\" must be from 0 (none) to 1 (all of the light) in each channel");
        }
        return rho;
    }

    double positive(const JsonValue& value, const std::string& what) const {
        const double number = checks_.number(value, what);
        if (!(number > 0.0)) {
            checks_.fail(value, what + " must be above 0, not " + text_of(number));
        }
        return number;
    }

    /// Metres in the unit of length that the object names.
    double unit(const JsonValue& object, double otherwise) const {
        static const std::vector<std::pair<std::string, double>> known{{"m", 1.0},  {"cm", 0.01},   {"mm", 0.001},
                                                                       {"km", 1e3}, {"in", 0.0254}, {"ft", 0.3048}};
        const JsonValue* value = object.find("unit");
        if (value == nullptr) {
            return otherwise;
        }
        if (value->kind == JsonValue::Kind::text) {
            for (const auto& [name, metres] : known) {
                if (value->text == name) {
                    return metres;
                }
            }
            checks_.fail(*value, "\"unit\" is " + excerpt(value->text) +
                                     "; it must be one of m cm mm km in ft, or a number of metres");
        }
        return positive(*value, quoted("unit"));
    }

    Vec3 direction(const JsonValue& value, const std::string& what) const {
        const Vec3 v = checks_.vector(value, what);
        if (v == Vec3::Zero()) {
            checks_.fail(value, what + " is no direction: it is zero");
        }
        return v.stableNormalized();
    }

    Vec3 up_direction(const JsonValue& value) const {
        if (value.kind == JsonValue::Kind::text) {
            for (int k = 0; k < 3; ++k) {
                if (value.text == std::string(1, "xyz"[k])) {
                    return Vec3::Unit(k);
                }
            }
            checks_.fail(value, "\"up\" is " + excerpt(value.text) + "; it must be x, y, z or a list of 3 numbers");
        }
        return direction(value, quoted("up"));
    }

    /// In metres.
    Vec3 position(const JsonValue& value, const std::string& what) const { return unit_ * checks_.vector(value, what); }

    /// A unit vector by the member `name`, or towards the point "look_at" from `from`.
    Vec3 direction_or_target(const JsonValue& object, const std::string& what, const char* name,
                             const Vec3& from) const {
        const JsonValue *given = object.find(name), *target = object.find("look_at");
        if ((given == nullptr) == (target == nullptr)) {
            checks_.fail(object, either_or(what, quoted(name), "\"look_at\"", given != nullptr));
        }
        if (given != nullptr) {
            return direction(*given, quoted(name));
        }
        const Vec3 way = position(*target, quoted("look_at")) - from;
        if (way == Vec3::Zero()) {
            checks_.fail(*target, "\"look_at\" is the place from where " + what + " looks");
        }
        return way.stableNormalized();
    }

    /// A name that should be among the `known`.
    [[noreturn]] void refuse_name(const JsonValue& at, const std::string& name, const std::string& missing,
                                  const std::vector<std::string>& known) const {
        const std::string near = nearest_name(name, known);
        std::string message = missing + (near.empty() ? "" : "; did you mean " + excerpt(near) + "?");
        if (near.empty()) {
            message += known.empty() ? "; it has none" : ". It has:";
            for (std::size_t i = 0; i < known.size() && i < 20; ++i) {
                message += (i == 0 ? " " : ", ") + excerpt(known[i]);
            }
            message += known.size() > 20 ? ", ..." : "";
        }
        checks_.fail(at, message);
    }

    /// The path of a file beside this one; it can be read.
    std::filesystem::path file(const JsonValue& value, const std::string& what) const {
        const std::string& name = checks_.text(value, what);
        const std::filesystem::path path = folder_ / name;
        try {
            check_readable(path);
        } catch (const InputError& error) {
            checks_.fail(value, what + ": " + error.what());
        }
        return path;
    }

    // ---- materials --------------------------------------------------------------------------------------------

    std::shared_ptr<const Texture> texture(const JsonValue& value, const std::string& what) {
        const std::filesystem::path path = file(value, what);
        try {
            return textures_.texture(path);
        } catch (const InputError& error) {
            checks_.fail(value, what + ": " + error.what());
        }
    }

    void read_materials(const JsonValue& materials) {
        checks_.object(materials, quoted("materials"));
        for (std::size_t i = 0; i < materials.names.size(); ++i) {
            const JsonValue& from = materials.items[i];
            checks_.members(
                from, "a material",
                {"reflectance", "reflectance_texture", "emission", "emission_texture", "double_sided", "light_group"});
            Material material;
            material.name = materials.names[i];
            const JsonValue *rho = from.find("reflectance"), *rho_texture = from.find("reflectance_texture");
            const JsonValue *emission = from.find("emission"), *emission_texture = from.find("emission_texture");
            material.reflectance = rho != nullptr           ? reflectance_of(*rho)
                                   : rho_texture != nullptr ? Rgb(Rgb::Ones())
                                                            : soup_.default_reflectance.value_or(material.reflectance);
            if (rho_texture != nullptr) {
                material.reflectance_texture = texture(*rho_texture, quoted("reflectance_texture"));
                if (!(material.reflectance * material.reflectance_texture->brightest() <= 1.0).all()) {
                    checks_.fail(*rho_texture, "the brightest pixel of \"reflectance_texture\" times \"reflectance\" "
                                               "is above 1: a surface reflects no more than all of the light");
                }
            }
            if (emission != nullptr) {
                material.emission = colour(*emission, quoted("emission"));
            } else if (emission_texture != nullptr) {
                checks_.fail(*emission_texture,
                             "\"emission_texture\" is a factor on \"emission\", in W/m^2, which is missing: add it");
            }
            if (emission_texture != nullptr) {
                material.emission_texture = texture(*emission_texture, quoted("emission_texture"));
            }
            if (const JsonValue* both = from.find("double_sided")) {
                material.double_sided = checks_.truth(*both, quoted("double_sided"));
            }
            if (const JsonValue* group = from.find("light_group")) {
                material.light_group = checks_.text(*group, quoted("light_group"));
            }
            materials_.emplace(material.name, static_cast<Index>(soup_.materials.size()));
            soup_.materials.push_back(std::move(material));
        }
    }

    Index material(const JsonValue& value) const {
        const std::string& name = checks_.text(value, "the name of a material");
        const auto found = materials_.find(name);
        if (found == materials_.end()) {
            std::vector<std::string> known;
            for (const auto& [each, number] : materials_) {
                known.push_back(each);
            }
            refuse_name(value, name, "\"materials\" of the scene has no " + excerpt(name), known);
        }
        return found->second;
    }

    // ---- lights -----------------------------------------------------------------------------------------------

    std::string name_of(const JsonValue& object) const {
        const JsonValue* name = object.find("name");
        return name == nullptr ? "" : checks_.text(*name, quoted("name"));
    }

    void read_light(const JsonValue& from) {
        const std::string what = "a light";
        checks_.object(from, what);
        const JsonValue& kind = checks_.required(from, what, "type");
        const std::string& type = checks_.text(kind, quoted("type"));
        if (type == "sun") {
            checks_.members(from, "a sun", {"type", "name", "towards", "irradiance"});
            soup_.lights.suns.push_back({direction(checks_.required(from, "a sun", "towards"), quoted("towards")),
                                         colour(checks_.required(from, "a sun", "irradiance"), quoted("irradiance")),
                                         name_of(from)});
        } else if (type == "point") {
            checks_.members(from, "a point light", {"type", "name", "position", "intensity", "power"});
            PointLight light;
            light.name = name_of(from);
            light.position = position(checks_.required(from, "a point light", "position"), quoted("position"));
            const JsonValue *intensity = from.find("intensity"), *power = from.find("power");
            if ((intensity == nullptr) == (power == nullptr)) {
                checks_.fail(from,
                             either_or("a point light", "\"intensity\" (W/sr)", "\"power\" (W)", power != nullptr));
            }
            light.intensity = intensity != nullptr ? colour(*intensity, quoted("intensity"))
                                                   : Rgb(colour(*power, quoted("power")) / (4.0 * std::numbers::pi));
            soup_.lights.points.push_back(light);
        } else if (type == "spot") {
            read_spot(from);
        } else {
            refuse_name(kind, type, "a light of \"type\" " + excerpt(type) + " is not known", {"sun", "point", "spot"});
        }
    }

    void read_spot(const JsonValue& from) {
        const std::string what = "a spot light";
        checks_.members(
            from, what,
            {"type", "name", "position", "direction", "look_at", "intensity", "inner_degrees", "outer_degrees"});
        PointLight light;
        light.name = name_of(from);
        light.position = position(checks_.required(from, what, "position"), quoted("position"));
        light.direction = direction_or_target(from, what, "direction", light.position);
        light.intensity = colour(checks_.required(from, what, "intensity"), quoted("intensity"));
        const JsonValue& outer = checks_.required(from, what, "outer_degrees");
        const double outer_degrees = positive(outer, quoted("outer_degrees"));
        const JsonValue* inner = from.find("inner_degrees");
        const double inner_degrees = inner == nullptr ? 0.0 : checks_.number(*inner, quoted("inner_degrees"));
        if (!(outer_degrees < 180.0) || !(inner_degrees >= 0.0) || !(inner_degrees <= outer_degrees)) {
            checks_.fail(outer, "the cone of a spot light needs 0 <= inner_degrees <= outer_degrees < 180 (angles "
                                "from its axis), not " +
                                    text_of(inner_degrees) + " and " + text_of(outer_degrees));
        }
        light.cos_inner = std::cos(inner_degrees * std::numbers::pi / 180.0);
        light.cos_outer = std::cos(outer_degrees * std::numbers::pi / 180.0);
        soup_.lights.points.push_back(light);
    }

    void read_sky(const JsonValue& from) {
        const std::string what = "a sky";
        checks_.object(from, what);
        const JsonValue& kind = checks_.required(from, what, "type");
        const std::string& type = checks_.text(kind, quoted("type"));
        const auto required_colour = [&](const char* name) {
            return colour(checks_.required(from, what, name), quoted(name));
        };
        if (type == "uniform") {
            checks_.members(from, what, {"type", "irradiance"});
            soup_.lights.sky = required_colour("irradiance");
        } else if (type == "gradient") {
            checks_.members(from, what, {"type", "zenith", "horizon", "ground"});
            soup_.lights.dome = std::make_shared<GradientSky>(required_colour("zenith"), required_colour("horizon"),
                                                              required_colour("ground"), up_);
        } else if (type == "image") {
            checks_.members(from, what, {"type", "file", "scale", "ahead", "split_suns"});
            read_sky_image(from);
        } else {
            refuse_name(kind, type, "a sky of \"type\" " + excerpt(type) + " is not known",
                        {"uniform", "gradient", "image"});
        }
    }

    void read_sky_image(const JsonValue& from) {
        const JsonValue& named = checks_.required(from, "a sky", "file");
        const std::filesystem::path path = file(named, quoted("file"));
        // Forward as in most programs: y where z is up, -z where y is up.
        Vec3 ahead = std::abs(up_.y()) > 0.9 ? Vec3(-Vec3::UnitZ()) : Vec3(Vec3::UnitY());
        if (const JsonValue* given = from.find("ahead")) {
            ahead = direction(*given, quoted("ahead"));
            if (!(ahead.cross(up_).norm() > 1e-6)) {
                checks_.fail(*given, "\"ahead\" must not be straight up or down");
            }
        }
        double scale = 1.0;
        if (const JsonValue* given = from.find("scale")) {
            scale = positive(*given, quoted("scale"));
            if (!(scale <= 1e30)) {
                checks_.fail(*given, "\"scale\" must be at most 1e30, not " + text_of(scale));
            }
        }
        const JsonValue* split = from.find("split_suns");
        const bool splits = split == nullptr || checks_.truth(*split, quoted("split_suns"));
        try {
            const ImageSky whole(read_image(path, PixelEncoding::srgb, soup_.notes), scale, up_, ahead);
            auto dome = std::make_shared<ImageSky>(whole);
            std::vector<Sun> suns = splits ? dome->split_suns(sun_limit) : std::vector<Sun>{};
            for (double limit = 2.0 * sun_limit; suns.size() > most_suns; limit *= 2.0) {
                dome = std::make_shared<ImageSky>(whole);
                suns = dome->split_suns(limit);
            }
            if (!suns.empty()) {
                soup_.notes.push_back(path.string() +
                                      ": its brightest spots count as suns: " + std::to_string(suns.size()));
            }
            // What the suns left is at most as bright as the limit, but where they are too wide or too many.
            const double bright = 2.0 * sun_limit * whole.mean();
            if (const double left = splits ? dome->solid_angle_above(bright) : 0.0; left > 0.0) {
                soup_.notes.push_back(path.string() + ": " + text_of(left) + " sr stay more than " +
                                      text_of(2.0 * sun_limit) +
                                      " times as bright as its mean, in spots too wide or too many to count as suns: "
                                      "rays find them by chance; use more (--rays), or darken them in the image");
            }
            soup_.lights.suns.insert(soup_.lights.suns.end(), suns.begin(), suns.end());
            soup_.lights.dome = std::move(dome);
        } catch (const InputError& error) {
            checks_.fail(named, "\"file\": " + std::string(error.what()));
        } catch (const std::invalid_argument& error) {
            checks_.fail(named, path.string() + ": " + error.what());
        }
    }

    Camera camera_of(const JsonValue& from) const {
        const std::string what = "a camera";
        checks_.members(from, what, {"eye", "look_at", "towards", "up", "view_degrees"});
        Camera camera;
        camera.eye = position(checks_.required(from, what, "eye"), quoted("eye"));
        camera.towards = direction_or_target(from, what, "towards", camera.eye);
        const JsonValue* up = from.find("up");
        camera.up = up == nullptr ? up_ : up_direction(*up);
        if (!(camera.up.cross(camera.towards).norm() > 1e-6)) {
            checks_.fail(from, "the camera looks straight along its \"up\": give it another \"up\"");
        }
        double degrees = 40.0;
        if (const JsonValue* view = from.find("view_degrees")) {
            degrees = positive(*view, quoted("view_degrees"));
            if (!(degrees < 180.0)) {
                checks_.fail(*view, "\"view_degrees\" must be below 180");
            }
        }
        camera.view_angle = degrees * std::numbers::pi / 180.0;
        return camera;
    }

    // ---- meshes -----------------------------------------------------------------------------------------------

    void read_mesh(const JsonValue& from) {
        const std::string what = "a mesh";
        checks_.members(from, what, {"file", "name", "unit", "transform", "material", "materials", "faces"});
        name_of(from);
        const JsonValue& named = checks_.required(from, what, "file");
        const std::filesystem::path path = folder_ / checks_.text(named, quoted("file"));
        if (lower_case(path.extension().string()) == ".json") {
            checks_.fail(named, "\"file\": a scene cannot be a mesh of another one: name its meshes here");
        }
        PolygonSoup mesh;
        file(named, quoted("file")); // throws, with the line here, if it cannot be read
        mesh = read_mesh_(path);
        check_indices(mesh);
        place(mesh, placement(from));
        const std::vector<Index> own = materials_of_faces(from, mesh);
        const std::size_t faces = soup_.face_count();
        append(soup_, std::move(mesh));
        for (std::size_t f = 0; f < own.size(); ++f) {
            if (own[f] != none) {
                soup_.face_material[faces + f] = own[f];
            }
        }
    }

    Placement placement(const JsonValue& from) const {
        Placement result;
        const double scale_to_metres = unit(from, unit_);
        if (const JsonValue* transform = from.find("transform")) {
            checks_.members(*transform, quoted("transform"), {"scale", "rotate", "translate", "matrix"});
            if (const JsonValue* matrix = transform->find("matrix")) {
                if (transform->names.size() > 1 &&
                    (transform->find("scale") != nullptr || transform->find("rotate") != nullptr ||
                     transform->find("translate") != nullptr)) {
                    checks_.fail(*matrix, "\"transform\" is either a \"matrix\" or scale, rotate and translate");
                }
                result = matrix_of(*matrix);
            } else {
                result = scale_rotate_translate(*transform);
            }
            const double determinant = result.linear.determinant();
            if (determinant == 0.0 || !std::isfinite(determinant)) {
                checks_.fail(*transform, "\"transform\" makes the mesh flat, or too large: its determinant is " +
                                             text_of(determinant));
            }
        }
        result.linear *= scale_to_metres;
        return result;
    }

    Placement matrix_of(const JsonValue& value) const {
        const std::vector<double> m = checks_.numbers(value, quoted("matrix"), 16);
        if (m[12] != 0.0 || m[13] != 0.0 || m[14] != 0.0 || m[15] != 1.0) {
            checks_.fail(value, "\"matrix\" has 16 numbers row by row, and the last row must be 0 0 0 1");
        }
        Placement result;
        for (std::size_t row = 0; row < 3; ++row) {
            const auto i = static_cast<Eigen::Index>(row);
            for (std::size_t column = 0; column < 3; ++column) {
                result.linear(i, static_cast<Eigen::Index>(column)) = m[4 * row + column];
            }
            result.offset[i] = unit_ * m[4 * row + 3];
        }
        return result;
    }

    Placement scale_rotate_translate(const JsonValue& from) const {
        Placement result;
        if (const JsonValue* scale = from.find("scale")) {
            const bool list_of_three = scale->kind == JsonValue::Kind::list && scale->items.size() == 3;
            if (scale->kind != JsonValue::Kind::number && !list_of_three) {
                checks_.fail(*scale, "\"scale\" must be a number or a list of 3 numbers");
            }
            const Vec3 factors = list_of_three ? checks_.vector(*scale, quoted("scale"))
                                               : Vec3(Vec3::Constant(checks_.number(*scale, quoted("scale"))));
            result.linear = factors.asDiagonal();
        }
        if (const JsonValue* rotate = from.find("rotate")) {
            const auto apply = [&](const JsonValue& turn) {
                checks_.members(turn, quoted("rotate"), {"axis", "degrees"});
                const Vec3 axis = direction(checks_.required(turn, quoted("rotate"), "axis"), quoted("axis"));
                const JsonValue& degrees = checks_.required(turn, quoted("rotate"), "degrees");
                result.linear = rotation(axis, checks_.number(degrees, quoted("degrees"))) * result.linear;
            };
            if (rotate->kind == JsonValue::Kind::list) {
                std::for_each(rotate->items.begin(), rotate->items.end(), apply);
            } else {
                apply(*rotate);
            }
        }
        if (const JsonValue* translate = from.find("translate")) {
            result.offset = position(*translate, quoted("translate"));
        }
        return result;
    }

    /// The materials of the scene that faces of a mesh have; `none` where the mesh file says. "material", then
    /// "materials", then "faces": the later ones win.
    std::vector<Index> materials_of_faces(const JsonValue& from, const PolygonSoup& mesh) const {
        std::vector<Index> own(mesh.face_count(), none);
        if (const JsonValue* all = from.find("material")) {
            std::fill(own.begin(), own.end(), material(*all));
        }
        if (const JsonValue* replaced = from.find("materials")) {
            replace_materials(*replaced, mesh, own);
        }
        if (const JsonValue* ranges = from.find("faces")) {
            for (const JsonValue& range : checks_.list(*ranges, quoted("faces"))) {
                checks_.members(range, "a range of faces", {"first", "last", "material"});
                const JsonValue& end = checks_.required(range, "a range of faces", "last");
                const std::size_t last = checks_.whole(end, quoted("last"));
                const std::size_t first =
                    checks_.whole(checks_.required(range, "a range of faces", "first"), quoted("first"));
                if (first > last || last >= mesh.face_count()) {
                    checks_.fail(end, "the faces " + std::to_string(first) + " to " + std::to_string(last) + " of " +
                                          mesh.file + ": it has faces from 0 to " + std::to_string(mesh.face_count()) +
                                          ", the last one not included");
                }
                const Index number = material(checks_.required(range, "a range of faces", "material"));
                std::fill(own.begin() + static_cast<std::ptrdiff_t>(first),
                          own.begin() + static_cast<std::ptrdiff_t>(last) + 1, number);
            }
        }
        return own;
    }

    void replace_materials(const JsonValue& replaced, const PolygonSoup& mesh, std::vector<Index>& own) const {
        checks_.object(replaced, quoted("materials"));
        std::vector<Index> by(mesh.materials.size(), none);
        for (std::size_t i = 0; i < replaced.names.size(); ++i) {
            const std::string& name = replaced.names[i];
            const Index number = material(replaced.items[i]);
            bool found = false;
            std::vector<std::string> known;
            for (std::size_t m = 0; m < mesh.materials.size(); ++m) {
                known.push_back(mesh.materials[m].name);
                if (known.back() == name) {
                    by[m] = number;
                    found = true;
                }
            }
            if (!found) {
                refuse_name(replaced.items[i], name, mesh.file + " has no material " + excerpt(name), known);
            }
        }
        for (std::size_t f = 0; f < own.size(); ++f) {
            const Index m = mesh.face_material[f];
            own[f] = m != none && by[m] != none ? by[m] : own[f];
        }
    }

    JsonChecks checks_;
    std::filesystem::path folder_;
    const MeshSource& read_mesh_;
    PolygonSoup soup_;
    TextureFiles textures_;
    std::map<std::string, Index> materials_; ///< numbers in the soup
    double unit_ = 1.0;                      ///< metres
    Vec3 up_ = Vec3::UnitZ();
};

} // namespace

PolygonSoup parse_scene(std::string_view content, const std::filesystem::path& name, const MeshSource& meshes) {
    return SceneFile(name, meshes).read(content);
}

PolygonSoup read_scene(const Registry& registry, const std::filesystem::path& file) {
    if (lower_case(file.extension().string()) != ".json") {
        return read_soup(registry, file);
    }
    return parse_scene(read_file(file), file,
                       [&](const std::filesystem::path& mesh) { return read_soup(registry, mesh); });
}

} // namespace difusa
