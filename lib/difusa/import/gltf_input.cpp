#include <difusa/import/gltf_input.h>

#include <difusa/import/file_content.h>

#include <algorithm>
#include <array>

namespace difusa {

namespace {

/// Supported extensions.
constexpr std::array<std::string_view, 6> extensions_read{
    "KHR_lights_punctual", "KHR_materials_emissive_strength", "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_unlit", "KHR_mesh_quantization",           "KHR_texture_transform"};
/// Extensions irrelevant to diffuse light: specular reflection, material variants other than the default, animations,
/// and annotations.
constexpr std::array<std::string_view, 11> extensions_without_meaning{
    "KHR_animation_pointer",   "KHR_materials_anisotropy",
    "KHR_materials_clearcoat", "KHR_materials_dispersion",
    "KHR_materials_ior",       "KHR_materials_iridescence",
    "KHR_materials_sheen",     "KHR_materials_specular",
    "KHR_materials_variants",  "KHR_xmp",
    "KHR_xmp_json_ld"};

} // namespace

bool is_known_gltf_extension(std::string_view extension) {
    return std::find(extensions_read.begin(), extensions_read.end(), extension) != extensions_read.end() ||
           std::find(extensions_without_meaning.begin(), extensions_without_meaning.end(), extension) !=
               extensions_without_meaning.end();
}

void GltfInput::note(const std::string& what, const std::string& meaning, const std::string& where,
                     std::size_t amount) {
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

void GltfInput::write_notes() {
    for (const Count& each : counts_) {
        std::string text = each.what + ": " + std::to_string(each.count);
        for (std::size_t i = 0; i < each.where.size(); ++i) {
            text += (i == 0 ? " (" : ", ") + each.where[i];
        }
        text += each.where.empty() ? "" : each.more ? ", ...)" : ")";
        soup_.notes.push_back(text + "; " + each.meaning);
    }
}

double GltfInput::number(const JsonValue& object, const char* name, double otherwise) const {
    const JsonValue* value = object.find(name);
    return value == nullptr ? otherwise : checks().number(*value, quoted(name));
}

Vec3 GltfInput::vector(const JsonValue& object, const char* name, const Vec3& otherwise) const {
    const JsonValue* value = object.find(name);
    return value == nullptr ? otherwise : checks().vector(*value, quoted(name));
}

std::string GltfInput::text(const JsonValue& object, const char* name, const std::string& otherwise) const {
    const JsonValue* value = object.find(name);
    return value == nullptr ? otherwise : checks().text(*value, quoted(name));
}

const JsonValue* GltfInput::extension(const JsonValue& object, std::string_view name) const {
    const JsonValue* extensions = object.find("extensions");
    const JsonValue* found = extensions == nullptr ? nullptr : extensions->find(name);
    if (found != nullptr) {
        checks().object(*found, quoted(name));
    }
    return found;
}

void GltfInput::check_extensions() const {
    const JsonValue* required = file_.root().find("extensionsRequired");
    if (required == nullptr) {
        return;
    }
    for (const JsonValue& each : checks().list(*required, quoted("extensionsRequired"))) {
        const std::string& name = checks().text(each, "an extension");
        if (is_known_gltf_extension(name)) {
            continue;
        }
        std::string remedy = "export the scene without it";
        if (name == "KHR_draco_mesh_compression" || name == "EXT_meshopt_compression" ||
            name == "KHR_meshopt_compression") {
            remedy = "export the scene without mesh compression";
        } else if (name == "KHR_texture_basisu" || name == "EXT_texture_webp" || name == "EXT_texture_avif" ||
                   name == "MSFT_texture_dds") {
            remedy = "export the scene with images in PNG or JPEG";
        } else if (name == "EXT_mesh_gpu_instancing") {
            remedy = "export each instance as a node of its own";
        } else if (name.starts_with("KHR_materials_") || name.starts_with("EXT_materials_")) {
            remedy = "export opaque metallic-roughness materials only";
        }
        checks().fail(each,
                      "the scene requires the extension " + excerpt(name) + ", which is not supported: " + remedy);
    }
}

} // namespace difusa
