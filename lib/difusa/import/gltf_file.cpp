#include <difusa/import/gltf_file.h>

#include <difusa/core/error.h>
#include <difusa/import/base64.h>
#include <difusa/import/byte_scanner.h>

#include <algorithm>
#include <bit>
#include <limits>

namespace difusa {

namespace {

using Component = GltfAccessor::Component;

std::size_t size_of(Component component) {
    switch (component) {
    case Component::int8:
    case Component::uint8:
        return 1;
    case Component::int16:
    case Component::uint16:
        return 2;
    case Component::uint32:
    case Component::float32:
        return 4;
    }
    return 0;
}

/// Little-endian, whatever the machine's order.
std::uint32_t whole_number(const char* bytes, std::size_t size) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < size; ++i) {
        value |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[i])) << (8 * i);
    }
    return value;
}

double component_at(const char* bytes, Component component, bool normalized) {
    const std::uint32_t bits = whole_number(bytes, size_of(component));
    const auto scaled = [&](double value, double top) { return normalized ? std::max(value / top, -1.0) : value; };
    switch (component) {
    case Component::int8:
        return scaled(static_cast<std::int8_t>(bits), 127.0);
    case Component::uint8:
        return scaled(bits, 255.0);
    case Component::int16:
        return scaled(static_cast<std::int16_t>(bits), 32767.0);
    case Component::uint16:
        return scaled(bits, 65535.0);
    case Component::uint32:
        return scaled(bits, 4294967295.0);
    case Component::float32:
        return static_cast<double>(std::bit_cast<float>(bits));
    }
    return 0.0;
}

/// False if a character is invalid there.
bool decode_uri(std::string_view text, std::string& bytes) {
    while (!text.empty() && text.back() == '=') {
        text.remove_suffix(1);
    }
    bytes.reserve(text.size() / 4 * 3 + 2);
    return decode_base64(text, Base64::url, bytes) == text.size();
}

/// "%20" and the like.
std::string without_percents(std::string_view uri) {
    const auto hexadecimal = [](char c) {
        return c >= '0' && c <= '9'   ? c - '0'
               : c >= 'a' && c <= 'f' ? c - 'a' + 10
               : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                      : -1;
    };
    std::string result;
    for (std::size_t i = 0; i < uri.size(); ++i) {
        if (uri[i] == '%' && i + 2 < uri.size() && hexadecimal(uri[i + 1]) >= 0 && hexadecimal(uri[i + 2]) >= 0) {
            result += static_cast<char>(16 * hexadecimal(uri[i + 1]) + hexadecimal(uri[i + 2]));
            i += 2;
        } else {
            result += uri[i];
        }
    }
    return result;
}

std::size_t components_of(const std::string& type) {
    return type == "SCALAR" ? 1 : type == "VEC2" ? 2 : type == "VEC3" ? 3 : type == "VEC4" ? 4 : 0;
}

} // namespace

double GltfAccessor::at(std::size_t i, std::size_t k) const {
    const char* vector = data_ == nullptr ? nullptr : data_ + i * stride_;
    if (!replaced_.empty()) {
        const auto found = std::lower_bound(replaced_.begin(), replaced_.end(), i);
        if (found != replaced_.end() && *found == i) {
            vector = replacements_ + static_cast<std::size_t>(found - replaced_.begin()) * components_ * size_;
        }
    }
    return vector == nullptr ? 0.0 : component_at(vector + k * size_, component_, normalized_);
}

GltfFile::GltfFile(std::string_view content, const std::filesystem::path& name)
    : checks_(name.string()), folder_(name.parent_path()), json_(content), size_(content.size()) {
    if (content.substr(0, 4) == "glTF") {
        split_binary(content);
    }
    root_ = parse_json(json_, checks_.file());
    checks_.object(root_, "a glTF file");
    const JsonValue& asset = checks_.required(root_, "a glTF file", "asset");
    checks_.object(asset, "\"asset\"");
    const std::string& version = checks_.text(checks_.required(asset, "\"asset\"", "version"), "\"version\"");
    if (version != "2" && version.substr(0, 2) != "2.") {
        checks_.fail(asset,
                     "glTF version " + version + " is not supported, only version 2: export the scene as glTF 2.0");
    }
    for (std::size_t i = 0; i < root_.names.size(); ++i) {
        for (const char* list : {"accessors", "bufferViews", "buffers", "images", "textures", "samplers", "materials",
                                 "meshes", "nodes", "scenes", "cameras"}) {
            if (root_.names[i] == list) {
                for (const JsonValue& each : checks_.list(root_.items[i], "\"" + root_.names[i] + "\"")) {
                    checks_.object(each, "each of \"" + root_.names[i] + "\"");
                }
            }
        }
    }
    const JsonValue* buffers = root_.find("buffers");
    contents_.resize(buffers == nullptr ? 0 : buffers->items.size());
}

void GltfFile::split_binary(std::string_view content) {
    constexpr std::uint32_t json = 0x4e4f534a, binary = 0x004e4942; // "JSON", "BIN\0"
    ByteScanner scanner(content, checks_.file(), std::endian::little, 4);
    const Expected header{"the header of a binary glTF file"};
    const auto version = scanner.take<std::uint32_t>(header);
    if (version != 2) {
        scanner.fail("binary glTF version " + std::to_string(version) +
                     " is not supported, only version 2: export the scene as glTF 2.0");
    }
    scanner.take<std::uint32_t>(header); // the length; that of the file itself is more reliable
    const auto chunk = [&](std::uint32_t& type) {
        const auto length = scanner.take<std::uint32_t>(header);
        type = scanner.take<std::uint32_t>(header);
        const std::size_t begin = scanner.offset();
        scanner.skip(length, {"the content of a binary glTF file"});
        return content.substr(begin, length);
    };
    std::uint32_t type = 0;
    json_ = chunk(type);
    if (type != json) {
        scanner.fail("the first chunk of a binary glTF file must be JSON: export the scene again");
    }
    while (scanner.remaining() >= 8) {
        const std::string_view data = chunk(type);
        if (type == binary && !has_binary_) {
            binary_ = data;
            has_binary_ = true;
        }
    }
}

const JsonValue& GltfFile::entry(const char* list, const JsonValue& index) const {
    const std::size_t number = checks_.whole(index, "an index into \"" + std::string(list) + "\"");
    const JsonValue* entries = root_.find(list);
    const std::size_t count = entries == nullptr ? 0 : entries->items.size();
    if (number >= count) {
        checks_.fail(index, "entry " + std::to_string(number) + " of \"" + list + "\" is requested, which has " +
                                std::to_string(count) + ": export the scene again");
    }
    return entries->items[number];
}

std::size_t GltfFile::whole(const JsonValue& object, const char* name, std::size_t otherwise) const {
    const JsonValue* value = object.find(name);
    return value == nullptr ? otherwise : checks_.whole(*value, quoted(name));
}

std::optional<std::string> GltfFile::embedded(const JsonValue& uri) const {
    const std::string& text = checks_.text(uri, "\"uri\"");
    if (text.substr(0, 5) != "data:") {
        return std::nullopt;
    }
    const std::size_t comma = text.find(',');
    constexpr std::string_view encoding = ";base64";
    std::string content;
    if (comma == std::string::npos || comma < encoding.size() ||
        std::string_view(text).substr(comma - encoding.size(), encoding.size()) != encoding ||
        !decode_uri(std::string_view(text).substr(comma + 1), content)) {
        checks_.fail(uri, "a \"data:\" URI that is not in base64: export the scene again");
    }
    return content;
}

std::filesystem::path GltfFile::beside(const JsonValue& uri) {
    const std::string& text = checks_.text(uri, "\"uri\"");
    if (text.find("://") != std::string::npos) {
        checks_.fail(uri, excerpt(text) + " is not a file next to the scene: download it, and refer to that copy");
    }
    std::filesystem::path file = find_beside(folder_, without_percents(text));
    file = file.empty() ? find_beside(folder_, text) : file;
    if (!file.empty()) {
        files_.push_back(file);
    }
    return file;
}

std::string_view GltfFile::buffer(const JsonValue& index) {
    const JsonValue& from = entry("buffers", index);
    const auto number = static_cast<std::size_t>(index.number);
    const std::size_t length = checks_.whole(checks_.required(from, "a buffer", "byteLength"), "\"byteLength\"");
    const JsonValue* uri = from.find("uri");
    std::string_view content = binary_;
    if (uri == nullptr) {
        if (number != 0 || !has_binary_) {
            checks_.fail(from, "buffer " + std::to_string(number) +
                                   " has no content: neither a \"uri\" nor a binary chunk; export the scene again");
        }
    } else {
        std::optional<std::string>& own = contents_[number];
        if (!own) {
            own = embedded(*uri);
            if (!own) {
                const std::filesystem::path file = beside(*uri);
                if (file.empty()) {
                    checks_.fail(*uri, "the file " + excerpt(uri->text) +
                                           " is missing: put it next to the glTF file, or export the scene as .glb");
                }
                own = read_file(file);
                size_ += own->size();
            }
        }
        content = *own;
    }
    if (length > content.size()) {
        checks_.fail(from, "buffer " + std::to_string(number) + " should have " + std::to_string(length) +
                               " bytes, but has " + std::to_string(content.size()) +
                               ": the file is truncated; export the scene again");
    }
    return content.substr(0, length);
}

GltfFile::View GltfFile::view(const JsonValue& index) {
    const JsonValue& from = entry("bufferViews", index);
    const std::string_view content = buffer(checks_.required(from, "a buffer view", "buffer"));
    const std::size_t offset = whole(from, "byteOffset", 0);
    const std::size_t length = checks_.whole(checks_.required(from, "a buffer view", "byteLength"), "\"byteLength\"");
    if (offset > content.size() || length > content.size() - offset) {
        checks_.fail(from, "buffer view " + std::to_string(static_cast<std::size_t>(index.number)) +
                               " is not within its buffer: export the scene again");
    }
    const std::size_t stride = whole(from, "byteStride", 0);
    if (from.find("byteStride") != nullptr && (stride < 4 || stride > 252)) {
        checks_.fail(from, "\"byteStride\" must be from 4 to 252: export the scene again");
    }
    return {content.substr(offset, length), stride};
}

std::string_view GltfFile::bytes(const JsonValue& view_index) {
    return view(view_index).bytes;
}

GltfAccessor GltfFile::accessor(const JsonValue& index, const std::string& what, std::size_t components,
                                bool one_more) {
    const JsonValue& from = entry("accessors", index);
    const std::string name = "accessor " + std::to_string(static_cast<std::size_t>(index.number)) + " (" + what + ")";
    GltfAccessor result;
    result.components_ = components_of(checks_.text(checks_.required(from, name, "type"), "\"type\""));
    if (result.components_ != components && !(one_more && result.components_ == components + 1)) {
        checks_.fail(from, name + " must have " + std::to_string(components) + " components: export the scene again");
    }
    const std::size_t type = checks_.whole(checks_.required(from, name, "componentType"), "\"componentType\"");
    if (type < 5120 || type > 5126 || type == 5124) {
        checks_.fail(from, name + " has the component type " + std::to_string(type) + ", which glTF does not have");
    }
    result.component_ = static_cast<Component>(type);
    result.size_ = size_of(result.component_);
    if (const JsonValue* normalized = from.find("normalized")) {
        result.normalized_ = checks_.truth(*normalized, "\"normalized\"");
    }
    result.count_ = checks_.whole(checks_.required(from, name, "count"), "\"count\"");
    if (result.count_ >= none) {
        checks_.fail(from, name + " has too many vectors");
    }
    const std::size_t vector = result.components_ * result.size_;
    if (const JsonValue* view_index = from.find("bufferView")) {
        const View place = view(*view_index);
        result.stride_ = place.stride == 0 ? vector : place.stride;
        const std::size_t offset = whole(from, "byteOffset", 0);
        const std::size_t needed = result.count_ == 0 ? 0 : (result.count_ - 1) * result.stride_ + vector;
        if (result.stride_ < vector || offset > place.bytes.size() || needed > place.bytes.size() - offset) {
            checks_.fail(from, name + " is not within its buffer view: export the scene again");
        }
        result.data_ = place.bytes.data() + offset;
    }
    if (const JsonValue* sparse = from.find("sparse")) {
        read_sparse(*sparse, result);
    }
    if (result.data_ == nullptr && result.count_ > size_) {
        checks_.fail(from, name + " has " + std::to_string(result.count_) +
                               " vectors without a buffer, more than the file has bytes: export the scene again");
    }
    return result;
}

void GltfFile::read_sparse(const JsonValue& sparse, GltfAccessor& accessor) {
    checks_.object(sparse, "\"sparse\"");
    const std::size_t count = checks_.whole(checks_.required(sparse, "\"sparse\"", "count"), "\"count\"");
    const JsonValue& indices = checks_.required(sparse, "\"sparse\"", "indices");
    const JsonValue& values = checks_.required(sparse, "\"sparse\"", "values");
    checks_.object(indices, "\"indices\"");
    checks_.object(values, "\"values\"");
    const std::size_t type =
        checks_.whole(checks_.required(indices, "\"indices\"", "componentType"), "\"componentType\"");
    if (type != 5121 && type != 5123 && type != 5125) {
        checks_.fail(indices, "\"indices\" of a sparse accessor must be unsigned: export the scene again");
    }
    const std::size_t size = size_of(static_cast<Component>(type)), vector = accessor.components_ * accessor.size_;
    const auto bytes_of = [&](const JsonValue& object, std::size_t each) {
        const std::string_view all = bytes(checks_.required(object, "\"sparse\"", "bufferView"));
        const std::size_t offset = whole(object, "byteOffset", 0);
        if (offset > all.size() || count > (all.size() - offset) / each) {
            checks_.fail(object, "a sparse accessor is not within its buffer view: export the scene again");
        }
        return all.data() + offset;
    };
    const char* const numbers = bytes_of(indices, size);
    accessor.replacements_ = bytes_of(values, vector);
    accessor.replaced_.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t number = whole_number(numbers + i * size, size);
        if (number >= accessor.count_ || (i > 0 && number <= accessor.replaced_.back())) {
            checks_.fail(indices,
                         "the indices of a sparse accessor must ascend and be in range: export the scene again");
        }
        accessor.replaced_.push_back(number);
    }
}

} // namespace difusa
