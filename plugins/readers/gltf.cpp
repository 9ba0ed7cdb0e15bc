// reader gltf: scenes in glTF 2.0 (.gltf, .glb), with materials, textures, lights and camera.
//
// Read: nodes with their places, triangles, strips and fans, vertex colours, base colour and emission with textures
// (PNG, JPEG; KHR_texture_transform), double-sided materials, point, spot and directional lights (KHR_lights_punctual),
// the first perspective camera. Lengths are metres; y stays up.
//
// A diffuse surface reflects base colour times (1 - metallic), or the diffuse colour of
// KHR_materials_pbrSpecularGlossiness times (1 - the largest channel of its specular colour), as the specifications
// have it. They also say that a material without "metallicFactor" is metal: it is black here, and noted, since
// exporters often mean paint. Unlit materials (KHR_materials_unlit) count as paint of their base colour. Faces of
// primitives without a material have the default reflectance (--reflectance), and not glTF's white metal. glTF counts
// light in photometric units, difusa in watts: 683 lm are taken for 1 W, the convention of exporters (its inverse turns
// them back), so 1 cd/m² of emission is pi/683 W/m², 1 cd of intensity 1/683 W/sr, and 1 lux of a sun 1/683 W/m².
//
// Noted: lines and points, vertices left over, transparency, metal and specular colour by texture (their means count),
// normal and occlusion textures, skins, morphs, instances, ranges of lights, materials with extensions that are not
// known here. Refused: a file that cannot do without an extension that is neither read here nor without meaning for
// diffuse light.
#include <difusa/core/error.h>
#include <difusa/core/memory.h>
#include <difusa/import/file_content.h>
#include <difusa/import/gltf_file.h>
#include <difusa/import/image_file.h>
#include <difusa/import/placement.h>
#include <difusa/import/reader.h>
#include <difusa/plugin/plugin.h>
#include <difusa/repair/texture_coordinates.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <string_view>

namespace {

using namespace difusa;

constexpr double lumens_per_watt = 683.0;

/// Extensions that are read.
constexpr std::array<std::string_view, 6> extensions_read{
    "KHR_lights_punctual", "KHR_materials_emissive_strength", "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_unlit", "KHR_mesh_quantization",           "KHR_texture_transform"};
/// Extensions that change nothing about diffuse light: of what is mirrored, of choices among materials other than the
/// one by default, of animations, and of remarks.
constexpr std::array<std::string_view, 11> extensions_without_meaning{
    "KHR_animation_pointer",   "KHR_materials_anisotropy",
    "KHR_materials_clearcoat", "KHR_materials_dispersion",
    "KHR_materials_ior",       "KHR_materials_iridescence",
    "KHR_materials_sheen",     "KHR_materials_specular",
    "KHR_materials_variants",  "KHR_xmp",
    "KHR_xmp_json_ld"};

bool can_be_read(std::string_view extension) {
    return std::find(extensions_read.begin(), extensions_read.end(), extension) != extensions_read.end() ||
           std::find(extensions_without_meaning.begin(), extensions_without_meaning.end(), extension) !=
               extensions_without_meaning.end();
}

std::string quoted(std::string_view name) {
    return "\"" + std::string(name) + "\"";
}

class GltfScene {
  public:
    GltfScene(std::string_view content, const std::filesystem::path& name, PolygonSoup& soup)
        : file_(content, name), checks_(file_.checks()), soup_(soup) {}

    void read() {
        check_extensions();
        soup_.colours_by_material = true;
        read_nodes();
        write_notes();
        settle_textures(soup_);
    }

  private:
    /// A picture on a material, and which of a vertex' coordinates place it.
    struct Map {
        std::shared_ptr<const Texture> texture;
        std::size_t set = 0;
    };
    struct Surface {
        Material material;
        std::size_t texture_set = 0;
    };
    struct Count {
        std::string what, meaning;
        std::size_t count = 0;
        std::vector<std::string> where; ///< different ones, as many as are named
        bool more = false;
    };

    /// `where`: a material or mesh by its name.
    void note(const std::string& what, const std::string& meaning, const std::string& where = {},
              std::size_t amount = 1) {
        constexpr std::size_t most_named = 5;
        auto each = std::find_if(counts_.begin(), counts_.end(), [&](const Count& c) { return c.what == what; });
        if (each == counts_.end()) {
            each = counts_.insert(each, Count{what, meaning, 0, {}, false});
        }
        each->count += amount;
        if (!where.empty() && std::find(each->where.begin(), each->where.end(), where) == each->where.end()) {
            if (each->where.size() < most_named) {
                each->where.push_back(where);
            } else {
                each->more = true;
            }
        }
    }

    void write_notes() {
        for (const Count& each : counts_) {
            std::string text = each.what + ": " + std::to_string(each.count);
            for (std::size_t i = 0; i < each.where.size(); ++i) {
                text += (i == 0 ? " (" : ", ") + each.where[i];
            }
            text += each.where.empty() ? "" : each.more ? ", ...)" : ")";
            soup_.notes.push_back(text + "; " + each.meaning);
        }
    }

    // ---- values -----------------------------------------------------------------------------------------------

    double number(const JsonValue& object, const char* name, double otherwise) const {
        const JsonValue* value = object.find(name);
        return value == nullptr ? otherwise : checks_.number(*value, quoted(name));
    }

    Vec3 vector(const JsonValue& object, const char* name, const Vec3& otherwise) const {
        const JsonValue* value = object.find(name);
        return value == nullptr ? otherwise : checks_.vector(*value, quoted(name));
    }

    std::string text(const JsonValue& object, const char* name, const std::string& otherwise) const {
        const JsonValue* value = object.find(name);
        return value == nullptr ? otherwise : checks_.text(*value, quoted(name));
    }

    /// The extension of an object, or null.
    const JsonValue* extension(const JsonValue& object, std::string_view name) const {
        const JsonValue* extensions = object.find("extensions");
        const JsonValue* found = extensions == nullptr ? nullptr : extensions->find(name);
        if (found != nullptr) {
            checks_.object(*found, quoted(name));
        }
        return found;
    }

    void check_extensions() {
        const JsonValue* required = file_.root().find("extensionsRequired");
        if (required == nullptr) {
            return;
        }
        for (const JsonValue& each : checks_.list(*required, quoted("extensionsRequired"))) {
            const std::string& name = checks_.text(each, "an extension");
            if (can_be_read(name)) {
                continue;
            }
            std::string remedy = "export the scene without it";
            if (name == "KHR_draco_mesh_compression" || name == "EXT_meshopt_compression" ||
                name == "KHR_meshopt_compression") {
                remedy = "export the scene without compression of meshes";
            } else if (name == "KHR_texture_basisu" || name == "EXT_texture_webp" || name == "EXT_texture_avif" ||
                       name == "MSFT_texture_dds") {
                remedy = "export the scene with pictures in PNG or JPEG";
            } else if (name == "EXT_mesh_gpu_instancing") {
                remedy = "export each instance as a node of its own";
            } else if (name.starts_with("KHR_materials_") || name.starts_with("EXT_materials_")) {
                remedy = "export opaque materials of metal and roughness alone";
            }
            checks_.fail(each, "the scene requires the extension " + excerpt(name) + ", which is not read: " + remedy);
        }
    }

    // ---- textures ---------------------------------------------------------------------------------------------

    /// Decoded once. Null, with a note, for a picture that is not there or not of a kind that glTF has by itself.
    std::shared_ptr<const Image> image(const JsonValue& texture, PixelEncoding encoding) {
        const JsonValue* source = texture.find("source");
        if (source == nullptr) {
            note("textures of kinds that are not read (KTX2, WebP)", "export pictures in PNG or JPEG");
            return nullptr;
        }
        const JsonValue& from = file_.entry("images", *source);
        const auto key = std::pair(static_cast<std::size_t>(source->number), encoding);
        if (const auto known = images_.find(key); known != images_.end()) {
            return known->second;
        }
        const std::string name = checks_.file() + ", image " + std::to_string(key.first);
        std::shared_ptr<const Image>& result = images_[key];
        std::vector<std::string> notes;
        if (const JsonValue* view = from.find("bufferView")) {
            result = std::make_shared<const Image>(decode_image(file_.bytes(*view), name, encoding, notes));
        } else {
            const JsonValue& uri = checks_.required(from, "an image", "uri");
            if (const std::optional<std::string> content = file_.embedded(uri)) {
                result = std::make_shared<const Image>(decode_image(*content, name, encoding, notes));
            } else if (const std::filesystem::path path = file_.beside(uri); !path.empty()) {
                result = std::make_shared<const Image>(read_image(path, encoding, notes));
            } else {
                note("pictures of textures that are not there",
                     "factors alone count; put the pictures beside the file");
            }
        }
        soup_.notes.insert(soup_.notes.end(), notes.begin(), notes.end());
        return result;
    }

    static Texture::Wrap wrap(std::size_t mode) {
        return mode == 33071 ? Texture::Wrap::clamp : mode == 33648 ? Texture::Wrap::mirror : Texture::Wrap::repeat;
    }

    /// KHR_texture_transform, with v upwards as textures have it here: u' = offset + R scale u, where R turns
    /// counterclockwise on the picture.
    TexturePlacement placement(const JsonValue& transform) const {
        const auto pair = [&](const char* name, double otherwise) {
            const JsonValue* value = transform.find(name);
            const std::vector<double> v =
                value == nullptr ? std::vector<double>(2, otherwise) : checks_.numbers(*value, quoted(name), 2);
            return Eigen::Vector2d(v[0], v[1]);
        };
        const Eigen::Vector2d offset = pair("offset", 0.0), scale = pair("scale", 1.0);
        const double angle = number(transform, "rotation", 0.0), c = std::cos(angle), s = std::sin(angle);
        Eigen::Matrix2d linear; // with v downwards
        linear << c * scale[0], s * scale[1], -s * scale[0], c * scale[1];
        // v = 1 - w and v' = 1 - w'.
        TexturePlacement result;
        result << linear(0, 0), -linear(0, 1), offset[0] + linear(0, 1), //
            -linear(1, 0), linear(1, 1), 1.0 - offset[1] - linear(1, 1);
        return result;
    }

    /// A "textureInfo" of the file.
    Map map(const JsonValue& from) {
        checks_.object(from, "a texture of a material");
        const JsonValue& index = checks_.required(from, "a texture of a material", "index");
        const JsonValue& texture = file_.entry("textures", index);
        const JsonValue* set = from.find("texCoord");
        TexturePlacement place = TexturePlacement::Identity();
        if (const JsonValue* transform = extension(from, "KHR_texture_transform")) {
            place = placement(*transform);
            set = transform->find("texCoord") != nullptr ? transform->find("texCoord") : set;
        }
        Map result{nullptr, set == nullptr ? 0 : checks_.whole(*set, quoted("texCoord"))};
        const std::shared_ptr<const Image> picture = image(texture, PixelEncoding::srgb);
        if (!picture) {
            return result;
        }
        std::size_t modes[2] = {10497, 10497};
        if (const JsonValue* sampler = texture.find("sampler")) {
            const JsonValue& modes_from = file_.entry("samplers", *sampler);
            modes[0] = static_cast<std::size_t>(number(modes_from, "wrapS", 10497.0));
            modes[1] = static_cast<std::size_t>(number(modes_from, "wrapT", 10497.0));
        }
        std::vector<std::pair<TexturePlacement, std::shared_ptr<const Texture>>>& made =
            textures_[static_cast<std::size_t>(index.number)];
        for (const auto& [known, same] : made) {
            if (known == place) {
                result.texture = same;
                return result;
            }
        }
        result.texture = std::make_shared<const Texture>(picture, wrap(modes[0]), wrap(modes[1]), place);
        made.emplace_back(place, result.texture);
        return result;
    }

    // ---- materials --------------------------------------------------------------------------------------------

    /// The image of a "textureInfo"; null as in image().
    std::shared_ptr<const Image> image_of(const JsonValue& from, PixelEncoding encoding) {
        checks_.object(from, "a texture of a material");
        return image(file_.entry("textures", checks_.required(from, "a texture of a material", "index")), encoding);
    }

    /// Metals have no diffuse part. Of a texture its mean counts.
    double metallic(const JsonValue& pbr, const std::string& name) {
        double factor = std::clamp(number(pbr, "metallicFactor", 1.0), 0.0, 1.0);
        if (const JsonValue* from = pbr.find("metallicRoughnessTexture"); from != nullptr && factor > 0.0) {
            if (const std::shared_ptr<const Image> picture = image_of(*from, PixelEncoding::linear)) {
                double sum = 0.0;
                for (const std::array<float, 3>& pixel : picture->pixels) {
                    sum += static_cast<double>(pixel[2]);
                }
                factor *= std::min(sum / static_cast<double>(picture->pixels.size()), 1.0);
            }
            note("materials whose metal is painted by a texture", "its mean counts everywhere", name);
        } else if (pbr.find("metallicFactor") == nullptr) {
            note("materials without \"metallicFactor\"",
                 "glTF then means metal, which has no diffuse part and is black here; for paint export "
                 "\"metallicFactor\": 0",
                 name);
            return 1.0;
        }
        note_mirror(factor, name);
        return factor;
    }

    /// The part that KHR_materials_pbrSpecularGlossiness mirrors, which is not diffuse: the largest channel of the
    /// specular colour. Of a texture its mean counts.
    double specular(const JsonValue& gloss, const std::string& name) {
        const Rgb factor = vector(gloss, "specularFactor", Vec3::Ones()).array().max(0.0).min(1.0);
        double largest = factor.maxCoeff();
        if (const JsonValue* from = gloss.find("specularGlossinessTexture"); from != nullptr && largest > 0.0) {
            if (const std::shared_ptr<const Image> picture = image_of(*from, PixelEncoding::srgb)) {
                double sum = 0.0;
                for (const std::array<float, 3>& pixel : picture->pixels) {
                    sum += (factor * Rgb(pixel[0], pixel[1], pixel[2])).maxCoeff();
                }
                largest = std::min(sum / static_cast<double>(picture->pixels.size()), 1.0);
            }
            note("materials whose specular colour is painted by a texture", "its mean counts everywhere", name);
        }
        note_mirror(largest, name);
        return largest;
    }

    void note_mirror(double share, const std::string& name) {
        if (share == 1.0) {
            note("materials of metal", "they have no diffuse part and are black here; mirrors are not computed", name);
        }
    }

    /// Four numbers, of which the last, opacity, does not count.
    Rgb colour(const JsonValue& object, const char* member) const {
        const JsonValue* factor = object.find(member);
        const std::vector<double> c =
            factor == nullptr ? std::vector<double>(4, 1.0) : checks_.numbers(*factor, quoted(member), 4);
        return {c[0], c[1], c[2]};
    }

    Surface surface(const JsonValue& from, std::size_t index) {
        Surface result;
        Material& material = result.material;
        material.name = text(from, "name", "");
        material.name = material.name.empty() ? "material " + std::to_string(index) : material.name;
        const std::string name = quoted(std::string_view(material.name));
        const JsonValue nothing;
        const JsonValue* given = from.find("pbrMetallicRoughness");
        const JsonValue& pbr = given == nullptr ? nothing : *given;
        const JsonValue* gloss = extension(from, "KHR_materials_pbrSpecularGlossiness");
        const JsonValue* base_texture = nullptr;
        if (extension(from, "KHR_materials_unlit") != nullptr) {
            material.reflectance = colour(pbr, "baseColorFactor");
            base_texture = pbr.find("baseColorTexture");
            note("unlit materials", "what they show counts as reflectance: light is computed here", name);
        } else if (gloss != nullptr) {
            material.reflectance = colour(*gloss, "diffuseFactor") * (1.0 - specular(*gloss, name));
            base_texture = gloss->find("diffuseTexture");
        } else {
            material.reflectance = colour(pbr, "baseColorFactor") * (1.0 - metallic(pbr, name));
            base_texture = pbr.find("baseColorTexture");
        }
        Map base_map, emission_map;
        if (base_texture != nullptr) {
            base_map = map(*base_texture);
            material.reflectance_texture = base_map.texture;
        }
        const JsonValue* strength = extension(from, "KHR_materials_emissive_strength");
        const double luminance = strength == nullptr ? 1.0 : number(*strength, "emissiveStrength", 1.0);
        material.emission =
            vector(from, "emissiveFactor", Vec3::Zero()).array() * (luminance * std::numbers::pi / lumens_per_watt);
        if (const JsonValue* texture = from.find("emissiveTexture")) {
            emission_map = map(*texture);
            material.emission_texture = emission_map.texture;
        }
        result.texture_set = base_map.texture ? base_map.set : emission_map.set;
        if (base_map.texture && emission_map.texture && base_map.set != emission_map.set) {
            note("materials whose textures use different coordinates", "the mean of the emission's counts", name);
            material.emission *= emission_map.texture->mean();
            material.emission_texture = nullptr;
        }
        if (const JsonValue* both = from.find("doubleSided")) {
            material.double_sided = checks_.truth(*both, quoted("doubleSided"));
        }
        if (text(from, "alphaMode", "OPAQUE") != "OPAQUE") {
            note("materials that are not opaque", "transparency is not read, every face is opaque", name);
        }
        if (from.find("normalTexture") != nullptr) {
            note("materials with normal textures", "they are not read: the shape is that of the triangles", name);
        }
        if (from.find("occlusionTexture") != nullptr) {
            note("materials with occlusion textures", "they are not read: shade is computed", name);
        }
        if (const JsonValue* extensions = from.find("extensions")) {
            checks_.object(*extensions, quoted("extensions"));
            for (const std::string& each : extensions->names) {
                if (!can_be_read(each)) {
                    note("materials with " + each, "it is not read, the rest of them counts", name);
                }
            }
        }
        return result;
    }

    const Surface& surface(const JsonValue& index) {
        const JsonValue& from = file_.entry("materials", index);
        const auto number_of = static_cast<std::size_t>(index.number);
        const auto known = surfaces_.find(number_of);
        return known != surfaces_.end() ? known->second
                                        : surfaces_.emplace(number_of, surface(from, number_of)).first->second;
    }

    /// The number in the soup of a material of the file (or of none), with the colours of vertices or without.
    Index material(const JsonValue* index, bool painted) {
        if (index == nullptr && !painted) {
            return none;
        }
        const std::size_t of_file =
            index == nullptr ? static_cast<std::size_t>(none) : static_cast<std::size_t>(index->number);
        const auto [place, is_new] =
            numbers_.try_emplace({of_file, painted}, static_cast<Index>(soup_.materials.size()));
        if (is_new) {
            Material made;
            made.name = "vertex colours";
            if (index != nullptr) {
                made = surface(*index).material;
            }
            made.vertex_colours = painted;
            soup_.materials.push_back(std::move(made));
        }
        return place->second;
    }

    // ---- meshes -----------------------------------------------------------------------------------------------

    void read_mesh(const JsonValue& index, const Placement& place) {
        const JsonValue& mesh = file_.entry("meshes", index);
        const std::string name = "mesh " + std::to_string(static_cast<std::size_t>(index.number));
        mesh_is_new_ = meshes_.insert(static_cast<std::size_t>(index.number)).second;
        if (mesh.find("weights") != nullptr) {
            note_mesh("meshes with morph targets", "their base shape is read", name);
        }
        for (const JsonValue& primitive :
             checks_.list(checks_.required(mesh, name, "primitives"), quoted("primitives"))) {
            read_primitive(primitive, name, place);
        }
    }

    /// Of a mesh that stands in many places only once.
    void note_mesh(const std::string& what, const std::string& meaning, const std::string& name,
                   std::size_t amount = 1) {
        if (mesh_is_new_) {
            note(what, meaning, name, amount);
        }
    }

    /// Three vertices of triangle t of a list (4), strip (5) or fan (6).
    static std::array<std::size_t, 3> triangle(std::size_t mode, std::size_t t) {
        if (mode == 4) {
            return {3 * t, 3 * t + 1, 3 * t + 2};
        }
        if (mode == 5) {
            return {t, t + 1 + t % 2, t + 2 - t % 2};
        }
        return {t + 1, t + 2, 0};
    }

    void read_primitive(const JsonValue& from, const std::string& name, const Placement& place) {
        checks_.object(from, "a primitive");
        if (extension(from, "KHR_draco_mesh_compression") != nullptr && from.find("attributes") != nullptr &&
            from.find("attributes")->names.empty()) {
            checks_.fail(from,
                         name + " is compressed (Draco), which is not read: export the scene without compression");
        }
        const JsonValue* mode_given = from.find("mode");
        const std::size_t mode = mode_given == nullptr ? 4 : checks_.whole(*mode_given, quoted("mode"));
        if (mode < 4 || mode > 6) {
            note_mesh("primitives of points or lines", "they carry no surface and are not read", name);
            return;
        }
        const JsonValue& attributes = checks_.required(from, "a primitive of " + name, "attributes");
        checks_.object(attributes, quoted("attributes"));
        const JsonValue* position_index = attributes.find("POSITION");
        if (position_index == nullptr) {
            note_mesh("primitives without positions", "they are not read", name);
            return;
        }
        const GltfAccessor positions = file_.accessor(*position_index, "POSITION", 3);
        const JsonValue* material_index = from.find("material");
        const Surface* const look = material_index == nullptr ? nullptr : &surface(*material_index);
        const std::string set = "TEXCOORD_" + std::to_string(look == nullptr ? 0 : look->texture_set);
        std::optional<GltfAccessor> textures, colours, indices;
        const auto matching = [&](const char* what, const JsonValue& index, std::size_t components, bool more) {
            GltfAccessor accessor = file_.accessor(index, what, components, more);
            if (accessor.count() != positions.count()) {
                checks_.fail(index, name + " has " + std::to_string(positions.count()) + " positions and " +
                                        std::to_string(accessor.count()) + " of " + what + ": export the scene again");
            }
            return accessor;
        };
        if (const JsonValue* index = attributes.find(set)) {
            textures = matching(set.c_str(), *index, 2, false);
        }
        if (const JsonValue* index = attributes.find("COLOR_0")) {
            colours = matching("COLOR_0", *index, 3, true);
        }
        if (const JsonValue* index = from.find("indices")) {
            indices = file_.accessor(*index, "indices", 1);
            if (indices->component() != GltfAccessor::Component::uint8 &&
                indices->component() != GltfAccessor::Component::uint16 &&
                indices->component() != GltfAccessor::Component::uint32) {
                checks_.fail(*index, name + " has indices that are not unsigned: export the scene again");
            }
        }
        if (from.find("targets") != nullptr) {
            note_mesh("primitives with morph targets", "their base shape is read", name);
        }
        const Index number_of_material = material(material_index, colours.has_value());
        if (number_of_material == none) {
            note_mesh("primitives without a material",
                      "their faces have the default reflectance (--reflectance); give them a material", name);
        }
        const Rgb factor = look == nullptr ? Rgb(Rgb::Ones()) : look->material.reflectance;

        // Vertices are numbered as faces come to them: many primitives may share one large array.
        std::vector<Index> vertex(positions.count(), none);
        const std::size_t count = indices ? indices->count() : positions.count();
        const std::size_t triangles = mode == 4 ? count / 3 : count < 3 ? 0 : count - 2;
        const std::size_t left_over = mode == 4 ? count % 3 : count < 3 ? count : 0;
        if (left_over > 0) {
            note_mesh("vertices left over that make no triangle", "they are not read; export the mesh again", name,
                      left_over);
        }
        require_room(triangles);
        for (std::size_t t = 0; t < triangles; ++t) {
            std::array<std::size_t, 3> corners = triangle(mode, t);
            for (std::size_t& corner : corners) {
                corner = indices ? static_cast<std::size_t>(indices->at(corner, 0)) : corner;
                if (corner >= positions.count()) {
                    checks_.fail(from, name + ", triangle " + std::to_string(t) + " names vertex " +
                                           std::to_string(corner) + " of " + std::to_string(positions.count()) +
                                           ": export the scene again");
                }
            }
            if (mode == 5 && (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0])) {
                continue; // where strips are joined
            }
            if (place.mirrors()) {
                std::swap(corners[1], corners[2]);
            }
            std::array<Index, 3> face;
            for (std::size_t k = 0; k < 3; ++k) {
                const std::size_t v = corners[k];
                if (vertex[v] == none) {
                    vertex[v] = static_cast<Index>(soup_.points.size());
                    soup_.points.push_back(place({positions.at(v, 0), positions.at(v, 1), positions.at(v, 2)}));
                    if (colours) {
                        add_colour(factor *
                                   Rgb(colours->at(v, 0), colours->at(v, 1), colours->at(v, 2)).max(0.0).min(1.0));
                    }
                }
                face[k] = vertex[v];
            }
            soup_.add_face(face, number_of_material, 0);
            if (textures) {
                soup_.corner_texture.resize(soup_.corners.size() - 3, nowhere);
                for (const std::size_t v : corners) {
                    soup_.corner_texture.emplace_back(textures->at(v, 0), 1.0 - textures->at(v, 1));
                }
            }
        }
        if (!soup_.point_reflectance.empty()) {
            soup_.point_reflectance.resize(soup_.points.size(), Rgb::Constant(0.5));
        }
        if (!soup_.corner_texture.empty()) {
            soup_.corner_texture.resize(soup_.corners.size(), nowhere);
        }
    }

    void add_colour(const Rgb& colour) {
        soup_.point_reflectance.resize(soup_.points.size() - 1, Rgb::Constant(0.5));
        soup_.point_reflectance.push_back(colour.max(0.0).min(1.0));
    }

    /// A mesh may stand in many places: a small file can ask for more than there is memory.
    void require_room(std::size_t triangles) {
        constexpr double bytes = 3 * (sizeof(Vec3) + sizeof(Rgb) + sizeof(TextureCoordinates) + sizeof(Index)) + 16;
        constexpr double step = 0x1p28;
        if (soup_.corners.size() + 3 * triangles >= none) {
            throw ResourceError(checks_.file() + ": with all instances of its meshes the scene has more triangles than "
                                                 "can be numbered (1.4e9): export it in parts");
        }
        if (static_cast<double>(soup_.face_count() + triangles) * bytes > asked_for_) {
            asked_for_ = static_cast<double>(soup_.face_count() + triangles) * bytes + step;
            require_memory(static_cast<double>(triangles) * bytes + step,
                           "the scene " + checks_.file() + " with all instances of its meshes", "export it in parts");
        }
    }

    // ---- nodes ------------------------------------------------------------------------------------------------

    /// A node's placement, and its rotation alone, which a scale of 0 leaves as it is. NaN: it cannot be told.
    struct NodePlace {
        Placement place;
        Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    };

    /// The axes of a matrix, of unit length. One that is lost is normal to the others.
    static Eigen::Matrix3d axes(const Eigen::Matrix3d& linear) {
        Eigen::Matrix3d result;
        for (Eigen::Index k = 0; k < 3; ++k) {
            result.col(k) = linear.col(k).stableNormalized();
        }
        for (Eigen::Index k = 0; k < 3; ++k) {
            if (result.col(k).isZero(0.0)) {
                const Vec3 normal = result.col((k + 1) % 3).cross(result.col((k + 2) % 3));
                result.col(k) = normal / normal.norm(); // NaN if another one is lost
            }
        }
        return result;
    }

    NodePlace placement_of(const JsonValue& node) const {
        NodePlace result;
        Placement& place = result.place;
        if (const JsonValue* matrix = node.find("matrix")) {
            const std::vector<double> m = checks_.numbers(*matrix, quoted("matrix"), 16); // column by column
            for (std::size_t column = 0; column < 3; ++column) {
                for (std::size_t row = 0; row < 3; ++row) {
                    place.linear(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column)) =
                        m[4 * column + row];
                }
                place.offset[static_cast<Eigen::Index>(column)] = m[12 + column];
            }
            result.turn = axes(place.linear);
            return result;
        }
        place.offset = vector(node, "translation", Vec3::Zero());
        const Vec3 scale = vector(node, "scale", Vec3::Ones());
        place.linear = scale.asDiagonal();
        if (const JsonValue* rotation = node.find("rotation")) {
            const std::vector<double> q = checks_.numbers(*rotation, quoted("rotation"), 4);
            const Eigen::Quaterniond turn(q[3], q[0], q[1], q[2]);
            if (!(turn.norm() > 0.0)) {
                checks_.fail(*rotation, "\"rotation\" is a quaternion of length 0: export the scene again");
            }
            result.turn = turn.normalized().toRotationMatrix();
            place.linear = result.turn * place.linear;
        }
        return result;
    }

    /// The nodes to begin with: those of the scene to be shown, or all that are no children.
    std::vector<const JsonValue*> roots() {
        std::vector<const JsonValue*> result;
        const JsonValue *scenes = file_.root().find("scenes"), *shown = file_.root().find("scene");
        if (scenes != nullptr && !scenes->items.empty()) {
            const JsonValue& scene = shown == nullptr ? scenes->items[0] : file_.entry("scenes", *shown);
            if (scenes->items.size() > 1) {
                soup_.notes.push_back("the file has " + std::to_string(scenes->items.size()) +
                                      " scenes, of which one is read: the one to be shown, or the first");
            }
            if (const JsonValue* nodes = scene.find("nodes")) {
                for (const JsonValue& node : checks_.list(*nodes, quoted("nodes"))) {
                    result.push_back(&node);
                }
            }
            return result;
        }
        const JsonValue* nodes = file_.root().find("nodes");
        if (nodes == nullptr) {
            return result;
        }
        std::set<double> children;
        for (const JsonValue& node : nodes->items) {
            if (const JsonValue* list = node.find("children")) {
                for (const JsonValue& child : checks_.list(*list, quoted("children"))) {
                    children.insert(checks_.number(child, quoted("children")));
                }
            }
        }
        own_indices_.resize(nodes->items.size());
        for (std::size_t n = 0; n < nodes->items.size(); ++n) {
            JsonValue& index = own_indices_[n];
            index.kind = JsonValue::Kind::number;
            index.number = static_cast<double>(n);
            index.line = nodes->items[n].line;
            if (!children.contains(index.number)) {
                result.push_back(&index);
            }
        }
        return result;
    }

    void read_nodes() {
        struct Step {
            const JsonValue* index;
            NodePlace parent;
        };
        std::vector<Step> open;
        for (const JsonValue* root : roots()) {
            open.push_back({root, {}});
        }
        std::reverse(open.begin(), open.end());
        const JsonValue* nodes = file_.root().find("nodes");
        std::vector<char> met(nodes == nullptr ? 0 : nodes->items.size(), 0);
        while (!open.empty()) {
            const Step step = open.back();
            open.pop_back();
            const JsonValue& node = file_.entry("nodes", *step.index);
            char& again = met[static_cast<std::size_t>(step.index->number)];
            if (again != 0) {
                checks_.fail(*step.index, "node " + std::to_string(static_cast<std::size_t>(step.index->number)) +
                                              " has two parents, or is its own: export the scene again");
            }
            again = 1;
            const NodePlace own = placement_of(node);
            const NodePlace place{step.parent.place * own.place, step.parent.turn * own.turn};
            read_node(node, place);
            if (const JsonValue* children = node.find("children")) {
                const std::vector<JsonValue>& list = checks_.list(*children, quoted("children"));
                for (std::size_t c = list.size(); c-- > 0;) {
                    open.push_back({&list[c], place});
                }
            }
        }
    }

    void read_node(const JsonValue& node, const NodePlace& place) {
        if (node.find("skin") != nullptr) {
            note("nodes with a skin", "their meshes are read as they are without it");
        }
        if (extension(node, "EXT_mesh_gpu_instancing") != nullptr) {
            note("nodes with many instances (EXT_mesh_gpu_instancing)",
                 "one is read; export each instance as a node of its own");
        }
        if (const JsonValue* mesh = node.find("mesh")) {
            read_mesh(*mesh, place.place);
        }
        if (const JsonValue* camera = node.find("camera")) {
            read_camera(*camera, place);
        }
        if (const JsonValue* light = extension(node, "KHR_lights_punctual")) {
            read_light(checks_.required(*light, quoted("KHR_lights_punctual"), "light"), place);
        }
    }

    /// Where a direction of the node points; its -z, along which cameras look and lights shine. What a scale of 0
    /// takes is told by the rotations alone.
    Vec3 turned(const JsonValue& at, const NodePlace& node, const Vec3& direction) const {
        const auto is_unit = [](const Vec3& v) { return std::abs(v.norm() - 1.0) < 1e-6; };
        Vec3 result = (node.place.linear * direction).stableNormalized();
        if (!is_unit(result)) {
            result = (node.turn * direction).stableNormalized();
        }
        if (!is_unit(result)) {
            checks_.fail(at, "where a camera or light points cannot be told, since the matrix of its node or of one "
                             "above it has a scale of 0: export the scene again");
        }
        return result;
    }

    void read_camera(const JsonValue& index, const NodePlace& place) {
        const JsonValue& from = file_.entry("cameras", index);
        const JsonValue* perspective = from.find("perspective");
        if (perspective == nullptr) {
            note("cameras without perspective", "they are not read");
            return;
        }
        if (soup_.camera) {
            note("further cameras", "the first one is read");
            return;
        }
        checks_.object(*perspective, quoted("perspective"));
        Camera camera;
        camera.eye = place.place.offset;
        camera.towards = turned(index, place, -Vec3::UnitZ());
        camera.up = turned(index, place, Vec3::UnitY());
        camera.view_angle = checks_.number(checks_.required(*perspective, "a camera", "yfov"), quoted("yfov"));
        if (!(camera.view_angle > 0.0 && camera.view_angle < std::numbers::pi) || !camera.eye.allFinite() ||
            !(camera.up.cross(camera.towards).norm() > 1e-6)) {
            checks_.fail(*perspective, "a camera that shows nothing (its \"yfov\" must be above 0 and below pi): "
                                       "export the scene again");
        }
        soup_.camera = camera;
    }

    void read_light(const JsonValue& index, const NodePlace& place) {
        const JsonValue* extension_of_root = extension(file_.root(), "KHR_lights_punctual");
        const std::size_t number_of = checks_.whole(index, quoted("light"));
        const JsonValue* lights = extension_of_root == nullptr ? nullptr : extension_of_root->find("lights");
        if (lights == nullptr || number_of >= checks_.list(*lights, quoted("lights")).size()) {
            checks_.fail(index, "light " + std::to_string(number_of) + " is not there: export the scene again");
        }
        const JsonValue& from = lights->items[number_of];
        checks_.object(from, "a light");
        const std::string& type = checks_.text(checks_.required(from, "a light", "type"), quoted("type"));
        const double intensity = number(from, "intensity", 1.0);
        const Rgb colour = vector(from, "color", Vec3::Ones()).array() * (intensity / lumens_per_watt);
        if (!(colour >= 0.0).all() || !(colour <= 1e30).all() || !place.place.offset.allFinite()) {
            checks_.fail(from, "a light has a colour or intensity that is negative or too large: correct it");
        }
        if (from.find("range") != nullptr) {
            note("lights with a range", "it is not read: light falls off with the square of the distance");
        }
        if (type == "directional") {
            soup_.lights.suns.push_back({turned(index, place, Vec3::UnitZ()), colour, text(from, "name", "")});
            return;
        }
        PointLight light;
        light.position = place.place.offset;
        light.intensity = colour;
        light.name = text(from, "name", "");
        if (type == "spot") {
            const JsonValue nothing;
            const JsonValue* spot = from.find("spot");
            const JsonValue& cone = spot == nullptr ? nothing : *spot;
            const double inner = number(cone, "innerConeAngle", 0.0);
            const double outer = number(cone, "outerConeAngle", 0.25 * std::numbers::pi);
            if (!(inner >= 0.0 && inner <= outer && outer > 0.0 && outer < std::numbers::pi)) {
                checks_.fail(cone.kind == JsonValue::Kind::null ? from : cone,
                             "the cone of a spot light needs 0 <= inner <= outer angle: export the scene again");
            }
            light.direction = turned(index, place, -Vec3::UnitZ());
            light.cos_inner = std::cos(inner);
            light.cos_outer = std::cos(outer);
        } else if (type != "point") {
            note("lights of a type that is not known", "they are not read");
            return;
        }
        soup_.lights.points.push_back(light);
    }

    inline static const TextureCoordinates nowhere =
        TextureCoordinates::Constant(std::numeric_limits<double>::quiet_NaN());

    GltfFile file_;
    const JsonChecks& checks_;
    PolygonSoup& soup_;
    std::vector<Count> counts_;
    std::map<std::pair<std::size_t, PixelEncoding>, std::shared_ptr<const Image>> images_;
    std::map<std::size_t, std::vector<std::pair<TexturePlacement, std::shared_ptr<const Texture>>>> textures_;
    std::map<std::size_t, Surface> surfaces_;
    std::map<std::pair<std::size_t, bool>, Index> numbers_; ///< of materials in the soup
    std::set<std::size_t> meshes_;                          ///< met
    bool mesh_is_new_ = true;                               ///< the one that is read had not been met
    std::vector<JsonValue> own_indices_;                    ///< of nodes, for a file without scenes
    double asked_for_ = 0x1p26;                             ///< bytes that are known to be there
};

class GltfReader final : public Reader {
  public:
    explicit GltfReader(const Parameters&) {}

    std::vector<std::string> extensions() const override { return {"gltf", "glb"}; }

    PolygonSoup read(const std::filesystem::path& file) const override { return parse(read_file(file), file); }

    PolygonSoup parse(std::string_view content, const std::filesystem::path& name) const override {
        PolygonSoup soup;
        soup.file = name.string();
        GltfScene(content, name, soup).read();
        return soup;
    }
};

} // namespace

DIFUSA_PLUGIN(reader, "gltf", GltfReader,
              "glTF 2.0 scenes with textures, lights and camera (.gltf .glb); 683 lm count as 1 W.", {})
