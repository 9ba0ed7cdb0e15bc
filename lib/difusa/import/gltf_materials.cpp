#include <difusa/import/gltf_materials.h>

#include <difusa/core/photometry.h>
#include <difusa/core/text.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace difusa {

std::shared_ptr<const Image> GltfMaterials::image(const JsonValue& texture, PixelEncoding encoding) {
    const JsonValue* source = texture.find("source");
    if (source == nullptr) {
        input_.note("textures of unsupported kinds (KTX2, WebP)", "export images in PNG or JPEG");
        return nullptr;
    }
    const JsonValue& from = input_.file().entry("images", *source);
    const auto key = std::pair(static_cast<std::size_t>(source->number), encoding);
    if (const auto known = images_.find(key); known != images_.end()) {
        return known->second;
    }
    const std::string name = input_.checks().file() + ", image " + std::to_string(key.first);
    std::shared_ptr<const Image>& result = images_[key];
    std::vector<std::string> notes;
    if (const JsonValue* view = from.find("bufferView")) {
        result = std::make_shared<const Image>(decode_image(input_.file().bytes(*view), name, encoding, notes));
    } else {
        const JsonValue& uri = input_.checks().required(from, "an image", "uri");
        if (const std::optional<std::string> content = input_.file().embedded(uri)) {
            result = std::make_shared<const Image>(decode_image(*content, name, encoding, notes));
        } else if (const std::filesystem::path path = input_.file().beside(uri); !path.empty()) {
            result = std::make_shared<const Image>(read_image(path, encoding, notes));
        } else {
            input_.note("missing texture images", "only the factors are used; put the images next to the file");
        }
    }
    input_.soup().notes.insert(input_.soup().notes.end(), notes.begin(), notes.end());
    return result;
}

Texture::Wrap GltfMaterials::wrap(const JsonValue& sampler, const char* name) const {
    const JsonValue* value = sampler.find(name);
    if (value == nullptr) {
        return Texture::Wrap::repeat;
    }
    switch (input_.checks().whole(*value, quoted(name))) {
    case 10497:
        return Texture::Wrap::repeat;
    case 33071:
        return Texture::Wrap::clamp;
    case 33648:
        return Texture::Wrap::mirror;
    }
    input_.checks().fail(*value, quoted(name) + " must be 10497 (repeat), 33071 (clamp) or 33648 (mirror), not " +
                                     text_of(value->number));
}

TexturePlacement GltfMaterials::placement(const JsonValue& transform) const {
    const auto pair = [&](const char* name, double otherwise) {
        const JsonValue* value = transform.find(name);
        const std::vector<double> v =
            value == nullptr ? std::vector<double>(2, otherwise) : input_.checks().numbers(*value, quoted(name), 2);
        return Eigen::Vector2d(v[0], v[1]);
    };
    const Eigen::Vector2d offset = pair("offset", 0.0), scale = pair("scale", 1.0);
    const double angle = input_.number(transform, "rotation", 0.0), c = std::cos(angle), s = std::sin(angle);
    Eigen::Matrix2d linear; // with v pointing down
    linear << c * scale[0], s * scale[1], -s * scale[0], c * scale[1];
    // v = 1 - w and v' = 1 - w'.
    TexturePlacement result;
    result << linear(0, 0), -linear(0, 1), offset[0] + linear(0, 1), //
        -linear(1, 0), linear(1, 1), 1.0 - offset[1] - linear(1, 1);
    return result;
}

GltfMaterials::Map GltfMaterials::map(const JsonValue& from) {
    input_.checks().object(from, "a texture of a material");
    const JsonValue& index = input_.checks().required(from, "a texture of a material", "index");
    const JsonValue& texture = input_.file().entry("textures", index);
    const JsonValue* set = from.find("texCoord");
    TexturePlacement place = TexturePlacement::Identity();
    if (const JsonValue* transform = input_.extension(from, "KHR_texture_transform")) {
        place = placement(*transform);
        set = transform->find("texCoord") != nullptr ? transform->find("texCoord") : set;
    }
    Map result{nullptr, set == nullptr ? 0 : input_.checks().whole(*set, quoted("texCoord"))};
    const std::shared_ptr<const Image> picture = image(texture, PixelEncoding::srgb);
    if (!picture) {
        return result;
    }
    std::array<Texture::Wrap, 2> modes{Texture::Wrap::repeat, Texture::Wrap::repeat};
    if (const JsonValue* sampler = texture.find("sampler")) {
        const JsonValue& from_sampler = input_.file().entry("samplers", *sampler);
        modes = {wrap(from_sampler, "wrapS"), wrap(from_sampler, "wrapT")};
    }
    std::vector<std::pair<TexturePlacement, std::shared_ptr<const Texture>>>& made =
        textures_[static_cast<std::size_t>(index.number)];
    for (const auto& [known, same] : made) {
        if (known == place) {
            result.texture = same;
            return result;
        }
    }
    result.texture = std::make_shared<const Texture>(picture, modes[0], modes[1], place);
    made.emplace_back(place, result.texture);
    return result;
}

std::shared_ptr<const Image> GltfMaterials::image_of(const JsonValue& from, PixelEncoding encoding) {
    input_.checks().object(from, "a texture of a material");
    return image(input_.file().entry("textures", input_.checks().required(from, "a texture of a material", "index")),
                 encoding);
}

double GltfMaterials::mean_of(const JsonValue& texture, std::size_t channel) {
    const std::shared_ptr<const Image> picture = image_of(texture, PixelEncoding::linear);
    if (picture == nullptr) {
        return 1.0;
    }
    double sum = 0.0;
    for (const std::array<float, 3>& pixel : picture->pixels) {
        sum += static_cast<double>(pixel[channel]);
    }
    return std::min(sum / static_cast<double>(picture->pixels.size()), 1.0);
}

double GltfMaterials::metallic(const JsonValue& pbr, const std::string& name) {
    double factor = std::clamp(input_.number(pbr, "metallicFactor", 1.0), 0.0, 1.0);
    if (const JsonValue* from = pbr.find("metallicRoughnessTexture"); from != nullptr && factor > 0.0) {
        factor *= mean_of(*from, 2);
        input_.note("materials whose metalness has a texture", "its mean is used everywhere", name);
    } else if (pbr.find("metallicFactor") == nullptr && !is_polished(pbr)) {
        input_.note("materials without \"metallicFactor\"",
                    "glTF then implies metal, which reflects glossily and not diffusely; for paint export "
                    "\"metallicFactor\": 0",
                    name);
        return 1.0;
    }
    return factor;
}

double GltfMaterials::roughness(const JsonValue& pbr, const std::string& name) {
    double factor = std::clamp(input_.number(pbr, "roughnessFactor", 1.0), 0.0, 1.0);
    if (const JsonValue* from = pbr.find("metallicRoughnessTexture"); from != nullptr && factor > 0.0) {
        factor *= mean_of(*from, 1);
        input_.note("materials whose roughness has a texture", "its mean is used everywhere", name);
    }
    return std::max(LobeShape::least_roughness, factor);
}

double GltfMaterials::specular(const JsonValue& gloss, const std::string& name) {
    const Rgb factor = input_.vector(gloss, "specularFactor", Vec3::Ones()).array().max(0.0).min(1.0);
    double largest = factor.maxCoeff();
    if (const JsonValue* from = gloss.find("specularGlossinessTexture"); from != nullptr && largest > 0.0) {
        if (const std::shared_ptr<const Image> picture = image_of(*from, PixelEncoding::srgb)) {
            double sum = 0.0;
            for (const std::array<float, 3>& pixel : picture->pixels) {
                sum += (factor * Rgb(pixel[0], pixel[1], pixel[2])).maxCoeff();
            }
            largest = std::min(sum / static_cast<double>(picture->pixels.size()), 1.0);
        }
        input_.note("materials whose specular colour has a texture", "its mean is used everywhere", name);
    }
    note_metal(largest, name);
    return largest;
}

bool GltfMaterials::is_polished(const JsonValue& pbr) const {
    return input_.number(pbr, "roughnessFactor", 1.0) == 0.0 && pbr.find("metallicRoughnessTexture") == nullptr;
}

void GltfMaterials::note_metal(double share, const std::string& name) {
    if (share == 1.0) {
        input_.note("metallic materials",
                    "they have no diffuse part and are black here; only metallic-roughness materials are mirrors, or "
                    "glossy",
                    name);
    }
}

Rgb GltfMaterials::colour(const JsonValue& object, const char* member) const {
    const JsonValue* factor = object.find(member);
    const std::vector<double> c =
        factor == nullptr ? std::vector<double>(4, 1.0) : input_.checks().numbers(*factor, quoted(member), 4);
    return {c[0], c[1], c[2]};
}

GltfMaterials::Surface GltfMaterials::surface(const JsonValue& from, std::size_t index) {
    Surface result;
    Material& material = result.material;
    material.name = input_.text(from, "name", "");
    material.name = material.name.empty() ? "material " + std::to_string(index) : material.name;
    const std::string name = quoted(std::string_view(material.name));
    const JsonValue nothing;
    const JsonValue* given = from.find("pbrMetallicRoughness");
    const JsonValue& pbr = given == nullptr ? nothing : *given;
    const JsonValue* gloss = input_.extension(from, "KHR_materials_pbrSpecularGlossiness");
    const JsonValue* base_texture = nullptr;
    if (input_.extension(from, "KHR_materials_unlit") != nullptr) {
        material.reflectance = colour(pbr, "baseColorFactor");
        base_texture = pbr.find("baseColorTexture");
        input_.note("unlit materials", "their colour is used as reflectance: light is computed here", name);
    } else if (gloss != nullptr) {
        material.reflectance = colour(*gloss, "diffuseFactor") * (1.0 - specular(*gloss, name));
        base_texture = gloss->find("diffuseTexture");
    } else {
        const Rgb base = colour(pbr, "baseColorFactor");
        const double metal = metallic(pbr, name);
        material.reflectance = base * (1.0 - metal);
        if (is_polished(pbr)) {
            material.mirror = base * metal;
        } else if (metal > 0.0 && (base > 0.0).any()) {
            material.gloss = Gloss{{LobeShape::Model::ggx, roughness(pbr, name)}, base * metal};
        }
        base_texture = pbr.find("baseColorTexture");
    }
    Map base_map, emission_map;
    if (base_texture != nullptr) {
        base_map = map(*base_texture);
        material.reflectance_texture = base_map.texture;
        if (base_map.texture && (material.mirror > 0.0).any()) {
            input_.note("mirrors whose colour has a texture", "its mean is used everywhere", name);
            material.mirror *= base_map.texture->mean();
        }
        if (base_map.texture && material.gloss) {
            input_.note("glossy materials whose colour has a texture", "the mean is used for the gloss", name);
            material.gloss->reflectance *= base_map.texture->mean();
        }
    }
    const JsonValue* strength = input_.extension(from, "KHR_materials_emissive_strength");
    const double luminance = strength == nullptr ? 1.0 : input_.number(*strength, "emissiveStrength", 1.0);
    material.emission =
        input_.vector(from, "emissiveFactor", Vec3::Zero()).array() * (luminance * std::numbers::pi / lumens_per_watt);
    input_.soup().photometric = input_.soup().photometric || (material.emission > 0.0).any();
    if (const JsonValue* texture = from.find("emissiveTexture")) {
        emission_map = map(*texture);
        material.emission_texture = emission_map.texture;
    }
    result.texture_set = base_map.texture ? base_map.set : emission_map.set;
    if (base_map.texture && emission_map.texture && base_map.set != emission_map.set) {
        input_.note("materials whose textures use different coordinates", "the mean of the emission texture is used",
                    name);
        material.emission *= emission_map.texture->mean();
        material.emission_texture = nullptr;
    }
    if (const JsonValue* both = from.find("doubleSided")) {
        material.double_sided = input_.checks().truth(*both, quoted("doubleSided"));
    }
    if (input_.text(from, "alphaMode", "OPAQUE") != "OPAQUE") {
        input_.note("materials that are not opaque", "transparency is ignored, every face is opaque", name);
    }
    if (from.find("normalTexture") != nullptr) {
        input_.note("materials with normal textures", "they are ignored: the shape is that of the triangles", name);
    }
    if (from.find("occlusionTexture") != nullptr) {
        input_.note("materials with occlusion textures", "they are ignored: occlusion is computed", name);
    }
    if (const JsonValue* extensions = from.find("extensions")) {
        input_.checks().object(*extensions, quoted("extensions"));
        for (const std::string& each : extensions->names) {
            if (!is_known_gltf_extension(each)) {
                input_.note("materials with " + each, "it is ignored, the rest of them is used", name);
            }
        }
    }
    return result;
}

const GltfMaterials::Surface& GltfMaterials::surface(const JsonValue& index) {
    const JsonValue& from = input_.file().entry("materials", index);
    const auto number_of = static_cast<std::size_t>(index.number);
    const auto known = surfaces_.find(number_of);
    return known != surfaces_.end() ? known->second
                                    : surfaces_.emplace(number_of, surface(from, number_of)).first->second;
}

Index GltfMaterials::material(const JsonValue* index, bool painted, const Rgb& mean_colour) {
    if (index == nullptr && !painted) {
        return none;
    }
    const std::size_t of_file =
        index == nullptr ? static_cast<std::size_t>(none) : static_cast<std::size_t>(index->number);
    const auto [place, is_new] =
        numbers_.try_emplace({of_file, painted, {mean_colour[0], mean_colour[1], mean_colour[2]}},
                             static_cast<Index>(input_.soup().materials.size()));
    if (is_new) {
        Material made;
        made.name = "vertex colours";
        if (index != nullptr) {
            made = surface(*index).material;
            made.mirror *= mean_colour;
            if (made.gloss) {
                made.gloss->reflectance *= mean_colour;
            }
        }
        made.vertex_colours = painted;
        input_.soup().materials.push_back(std::move(made));
    }
    return place->second;
}

} // namespace difusa
