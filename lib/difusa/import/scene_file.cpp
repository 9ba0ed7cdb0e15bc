#include <difusa/import/scene_file.h>

#include <difusa/core/error.h>
#include <difusa/core/text.h>
#include <difusa/import/file_content.h>
#include <difusa/import/placement.h>
#include <difusa/import/reader.h>
#include <difusa/import/scene_checks.h>
#include <difusa/import/scene_lights.h>
#include <difusa/import/scene_repetition.h>
#include <difusa/import/scene_thermal.h>
#include <difusa/import/text_scanner.h>
#include <difusa/import/texture_files.h>
#include <difusa/repair/soup_check.h>
#include <difusa/repair/texture_coordinates.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <vector>

namespace difusa {

namespace {

class SceneFile {
  public:
    SceneFile(const std::filesystem::path& name, const MeshSource& meshes) : checks_(name), read_mesh_(meshes) {
        soup_.file = name.string();
    }

    PolygonSoup read(std::string_view content) {
        const JsonValue root = parse_json(content, checks_.file());
        checks_.object(root, "a scene file");
        if (root.find("difusa_scene") == nullptr) {
            checks_.fail(root, "this JSON file is not a difusa scene: those begin with \"difusa_scene\": 1");
        }
        if (const JsonValue& version = *root.find("difusa_scene"); version.number != 1.0) {
            checks_.fail(version, "\"difusa_scene\" is the format version, and must be 1");
        }
        checks_.members(root, "a scene",
                        {"difusa_scene", "unit", "up", "meshes", "materials", "lights", "sky", "surroundings", "camera",
                         "symmetry", "periodic", "defaults"});
        checks_.read_conventions(root);
        soup_.up = checks_.up();
        soup_.says_up = true;
        if (const JsonValue* defaults = root.find("defaults")) {
            checks_.members(*defaults, quoted("defaults"), {"reflectance"});
            if (const JsonValue* reflectance = defaults->find("reflectance")) {
                soup_.default_reflectance = checks_.reflectance_of(*reflectance);
            }
        }
        if (const JsonValue* materials = root.find("materials")) {
            read_materials(*materials);
        }
        if (const JsonValue* lights = root.find("lights")) {
            for (const JsonValue& light : checks_.list(*lights, quoted("lights"))) {
                read_scene_light(checks_, light, soup_);
            }
        }
        if (const JsonValue* sky = root.find("sky")) {
            read_scene_sky(checks_, *sky, soup_);
        }
        if (const JsonValue* surroundings = root.find("surroundings")) {
            soup_.surroundings = scene_surroundings(checks_, *surroundings);
        }
        if (const JsonValue* symmetry = root.find("symmetry")) {
            soup_.repetition.planes = scene_symmetry(checks_, *symmetry);
        }
        if (const JsonValue* periodic = root.find("periodic")) {
            soup_.repetition.periods = scene_periods(checks_, *periodic);
        }
        if (const JsonValue* camera = root.find("camera")) {
            soup_.camera = scene_camera(checks_, *camera);
        }
        const JsonValue& meshes = checks_.required(root, "a scene", "meshes");
        if (checks_.list(meshes, quoted("meshes")).empty()) {
            checks_.fail(meshes, "a scene needs a mesh: add {\"file\": ...} to \"meshes\"");
        }
        for (const JsonValue& mesh : meshes.items) {
            read_mesh(mesh);
        }
        report_unused_materials(root);
        textures_.report(soup_);
        settle_textures(soup_);
        for (const PolygonSoup::ClearSun& sun : soup_.clear_suns) {
            soup_.lights.suns[sun.number].irradiance = Rgb::Constant(soup_.photometric ? sun.light : sun.radiated);
        }
        return std::move(soup_);
    }

  private:
    // ---- materials --------------------------------------------------------------------------------------------

    std::shared_ptr<const Texture> texture(const JsonValue& value, const std::string& what) {
        const std::filesystem::path path = checks_.file_beside(value, what);
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
            if (materials.names[i] == "comment" && from.kind != JsonValue::Kind::object) {
                continue;
            }
            std::vector<std::string> known{"reflectance", "reflectance_texture", "mirror",           "gloss",
                                           "emission",    "luminance",           "emission_texture", "double_sided",
                                           "light_group"};
            known.insert(known.end(), thermal_members().begin(), thermal_members().end());
            checks_.members(from, "a material", known);
            Material material;
            material.name = materials.names[i];
            const JsonValue *rho = from.find("reflectance"), *rho_texture = from.find("reflectance_texture");
            const JsonValue *emission = from.find("emission"), *emission_texture = from.find("emission_texture");
            material.reflectance = rho != nullptr           ? checks_.reflectance_of(*rho)
                                   : rho_texture != nullptr ? Rgb(Rgb::Ones())
                                                            : soup_.default_reflectance.value_or(material.reflectance);
            if (rho_texture != nullptr) {
                material.reflectance_texture = texture(*rho_texture, quoted("reflectance_texture"));
                if (!(material.reflectance * material.reflectance_texture->brightest() <= 1.0).all()) {
                    checks_.fail(*rho_texture, "the brightest pixel of \"reflectance_texture\" times \"reflectance\" "
                                               "is above 1: a surface cannot reflect more than all of the light");
                }
            }
            if (const JsonValue* mirror = from.find("mirror")) {
                material.mirror = checks_.reflectance_of(*mirror, "mirror");
                if (rho == nullptr && rho_texture == nullptr) {
                    material.reflectance = Rgb::Zero(); // nothing but a mirror
                }
                if (!material.reflects_at_most_all(material.brightest_reflectance())) {
                    checks_.fail(*mirror, std::string("\"mirror\" and ") +
                                              (rho_texture != nullptr ? "the brightest pixel of the reflectance"
                                                                      : "\"reflectance\"") +
                                              " add up to more than 1: a surface cannot reflect more than all of the "
                                              "light");
                }
            }
            if (const JsonValue* gloss = from.find("gloss")) {
                material.gloss = read_gloss(*gloss);
                if (rho == nullptr && rho_texture == nullptr && !material.vertex_colours) {
                    material.reflectance = Rgb::Zero(); // nothing but gloss
                }
                if (!material.reflects_at_most_all(material.brightest_reflectance())) {
                    checks_.fail(*gloss, "the reflectances of \"gloss\", of \"mirror\" and the diffuse one add up to "
                                         "more than 1: a surface cannot reflect more than all of the light");
                }
            }
            material.thermal = scene_thermal(checks_, from, material.mirror);
            if (emission != nullptr || from.find("luminance") != nullptr) {
                const Rgb light = checks_.light(from, "a material", "emission", "luminance", soup_.photometric);
                material.emission = emission != nullptr ? light : Rgb(std::numbers::pi * light); // diffuse
            } else if (emission_texture != nullptr) {
                checks_.fail(
                    *emission_texture,
                    "\"emission_texture\" multiplies \"emission\", in W/m^2, or \"luminance\", in cd/m^2, which "
                    "is missing: add it");
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

    double in_range(const JsonValue& value, const char* name, double least, double most) const {
        const double number = checks_.number(value, quoted(name));
        if (!(number >= least) || !(number <= most)) {
            checks_.fail(value, quoted(name) + " must be from " + text_of(least) + " to " + text_of(most));
        }
        return number;
    }

    Gloss read_gloss(const JsonValue& from) const {
        checks_.members(from, "a gloss", {"reflectance", "exponent", "roughness"});
        const JsonValue *exponent = from.find("exponent"), *roughness = from.find("roughness");
        if ((exponent == nullptr) == (roughness == nullptr)) {
            checks_.fail(from, "\"gloss\" needs either \"exponent\", of a Phong lobe, or \"roughness\", of GGX");
        }
        Gloss gloss;
        gloss.reflectance = checks_.reflectance_of(checks_.required(from, "a gloss", "reflectance"));
        gloss.shape =
            exponent != nullptr
                ? LobeShape{LobeShape::Model::phong,
                            in_range(*exponent, "exponent", LobeShape::least_exponent, LobeShape::most_exponent)}
                : LobeShape{LobeShape::Model::ggx, in_range(*roughness, "roughness", LobeShape::least_roughness, 1.0)};
        return gloss;
    }

    Index material(const JsonValue& value) const {
        const std::string& name = checks_.text(value, "the name of a material");
        const auto found = materials_.find(name);
        if (found == materials_.end()) {
            std::vector<std::string> known;
            for (const auto& [each, number] : materials_) {
                known.push_back(each);
            }
            checks_.refuse_name(value, name, "\"materials\" of the scene has no " + excerpt(name), known);
        }
        return found->second;
    }

    // ---- meshes -----------------------------------------------------------------------------------------------

    void read_mesh(const JsonValue& from) {
        const std::string what = "a mesh";
        checks_.members(from, what, {"file", "name", "unit", "transform", "flip", "material", "materials", "faces"});
        const std::string name = checks_.name_of(from);
        const JsonValue& named = checks_.required(from, what, "file");
        const std::filesystem::path path = checks_.folder() / checks_.text(named, quoted("file"));
        if (lower_case(path.extension().string()) == ".json") {
            checks_.fail(named, "\"file\": a scene cannot be used as a mesh: name its meshes here");
        }
        PolygonSoup mesh;
        checks_.file_beside(named, quoted("file")); // throws, naming this line, if it cannot be read
        mesh = read_mesh_(path);
        check_indices(mesh);
        place(mesh, placement(from, mesh.unit.value_or(checks_.unit())));
        note_other_up(from, mesh);
        if (const JsonValue* flip = from.find("flip"); flip != nullptr && checks_.truth(*flip, quoted("flip"))) {
            turn_over(mesh);
        }
        const std::vector<Index> own = materials_of_faces(from, mesh);
        forget_replaced_names(own, mesh);
        const std::size_t faces = soup_.face_count(), parts = soup_.parts.size();
        append(soup_, std::move(mesh));
        for (std::size_t part = parts; part < soup_.parts.size(); ++part) {
            soup_.parts[part].name = name;
        }
        for (std::size_t f = 0; f < own.size(); ++f) {
            if (own[f] != none) {
                soup_.face_material[faces + f] = own[f];
            }
        }
    }

    /// A file that says which way is up is expected to stand upright.
    void note_other_up(const JsonValue& from, const PolygonSoup& mesh) {
        const JsonValue* const transform = from.find("transform");
        const bool turned =
            transform != nullptr && (transform->find("rotate") != nullptr || transform->find("matrix") != nullptr);
        if (mesh.says_up && !turned && mesh.up.dot(soup_.up) < 1.0 - 1e-6) {
            soup_.notes.push_back(mesh.file + ": up is " + coordinates(mesh.up) + " in this file and " +
                                  coordinates(soup_.up) +
                                  " in the scene: turn the mesh (\"rotate\" in \"transform\"), "
                                  "or say \"up\" in the scene");
        }
    }

    /// `unit`: metres per unit of length of the mesh, unless `from` says otherwise.
    Placement placement(const JsonValue& from, double unit) const {
        Placement result;
        const double scale_to_metres = checks_.unit_of(from, unit);
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
            result.offset[i] = checks_.unit() * m[4 * row + 3];
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
                const Vec3 axis = checks_.direction(checks_.required(turn, quoted("rotate"), "axis"), quoted("axis"));
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
            result.offset = checks_.position(*translate, quoted("translate"));
        }
        return result;
    }

    /// The scene's materials assigned to the faces of a mesh; `none` where the mesh file decides. Those of the names
    /// that the mesh file uses and does not define, then "material", then "materials", then "faces": later ones
    /// override earlier ones.
    std::vector<Index> materials_of_faces(const JsonValue& from, const PolygonSoup& mesh) const {
        std::vector<Index> own = materials_by_name(mesh);
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
                if (first > last) {
                    checks_.fail(end, "the faces from " + std::to_string(first) + " to " + std::to_string(last) +
                                          " are none: the last of a range must not come before the first");
                }
                if (last >= mesh.face_count()) {
                    checks_.fail(end, "the faces " + std::to_string(first) + " to " + std::to_string(last) + " of " +
                                          mesh.file + ": it has " +
                                          (mesh.face_count() == 1
                                               ? std::string("face 0 alone")
                                               : "faces from 0 to " + std::to_string(mesh.face_count() - 1)));
                }
                const Index number = material(checks_.required(range, "a range of faces", "material"));
                std::fill(own.begin() + static_cast<std::ptrdiff_t>(first),
                          own.begin() + static_cast<std::ptrdiff_t>(last) + 1, number);
            }
        }
        return own;
    }

    std::vector<Index> materials_by_name(const PolygonSoup& mesh) const {
        std::vector<Index> by(mesh.materials.size(), none);
        for (std::size_t m = 0; m < by.size(); ++m) {
            const auto known = materials_.find(mesh.materials[m].name);
            by[m] = mesh.materials[m].is_undefined && known != materials_.end() ? known->second : none;
        }
        std::vector<Index> own(mesh.face_count(), none);
        for (std::size_t f = 0; f < own.size(); ++f) {
            const Index m = mesh.face_material[f];
            own[f] = m == none ? none : by[m];
        }
        return own;
    }

    /// Nothing is to be said about undefined materials of a mesh if no face is left with one.
    static void forget_replaced_names(const std::vector<Index>& own, PolygonSoup& mesh) {
        for (std::size_t f = 0; f < own.size(); ++f) {
            const Index material = mesh.face_material[f];
            if (own[f] == none && material != none && mesh.materials[material].is_undefined) {
                return;
            }
        }
        std::erase(mesh.notes, mesh.undefined_note);
    }

    /// Materials of the scene that no face has. If these are all of the thermal ones, the scene would be baked as one
    /// that is lit.
    void report_unused_materials(const JsonValue& root) {
        const std::set<Index> used(soup_.face_material.begin(), soup_.face_material.end());
        std::string unused;
        std::size_t count = 0;
        for (const auto& [name, number] : materials_) {
            if (!used.contains(number)) {
                unused += (count++ == 0 ? "" : ", ") + excerpt(name);
            }
        }
        constexpr const char* remedy = "assign materials in \"meshes\", by \"material\" (to all faces), "
                                       "\"materials\" ({\"name in the mesh file\": \"name here\"}) or \"faces\"";
        const auto is_thermal = [&](Index m) { return m != none && soup_.materials[m].thermal.has_value(); };
        if (std::any_of(materials_.begin(), materials_.end(),
                        [&](const auto& each) { return is_thermal(each.second); }) &&
            std::none_of(used.begin(), used.end(), is_thermal)) {
            checks_.fail(*root.find("materials"),
                         "no face has any of the materials with a temperature or a net flux: " + std::string(remedy));
        }
        if (count > 0) {
            soup_.notes.push_back(counted(count, "material") + " of the scene that no face has: " + unused + "; " +
                                  remedy);
        }
    }

    void replace_materials(const JsonValue& replaced, const PolygonSoup& mesh, std::vector<Index>& own) const {
        checks_.object(replaced, quoted("materials"));
        std::vector<Index> by(mesh.materials.size(), none);
        for (std::size_t i = 0; i < replaced.names.size(); ++i) {
            const std::string& name = replaced.names[i];
            std::vector<std::string> known;
            for (const Material& each : mesh.materials) {
                known.push_back(each.name);
            }
            const bool found = std::find(known.begin(), known.end(), name) != known.end();
            if (!found && name == "comment") {
                continue;
            }
            const Index number = material(replaced.items[i]);
            for (std::size_t m = 0; m < known.size(); ++m) {
                by[m] = known[m] == name ? number : by[m];
            }
            if (!found) {
                checks_.refuse_name(replaced.items[i], name, mesh.file + " has no material " + excerpt(name), known);
            }
        }
        for (std::size_t f = 0; f < own.size(); ++f) {
            const Index m = mesh.face_material[f];
            own[f] = m != none && by[m] != none ? by[m] : own[f];
        }
    }

    SceneChecks checks_;
    const MeshSource& read_mesh_;
    PolygonSoup soup_;
    TextureFiles textures_;
    std::map<std::string, Index> materials_; ///< numbers in the soup
};

} // namespace

PolygonSoup parse_scene(std::string_view content, const std::filesystem::path& name, const MeshSource& meshes) {
    return SceneFile(name, meshes).read(content);
}

PolygonSoup read_scene(const Registry& registry, const std::filesystem::path& file) {
    if (lower_case(file.extension().string()) != ".json") {
        return read_soup(registry, file);
    }
    PolygonSoup soup = parse_scene(read_file(file), file,
                                   [&](const std::filesystem::path& mesh) { return read_soup(registry, mesh); });
    soup.files.insert(soup.files.begin(), file);
    return soup;
}

} // namespace difusa
