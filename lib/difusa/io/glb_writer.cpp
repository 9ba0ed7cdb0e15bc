// glTF 2.0 in one binary file (Khronos Group, "glTF 2.0 Specification", 4.4 and 5): for engines and modellers that read
// neither VTK nor large PLY files. The material is unlit (KHR_materials_unlit): what is seen is the baked light.
#include <difusa/core/colour.h>
#include <difusa/core/error.h>
#include <difusa/io/byte_stream.h>
#include <difusa/io/field_writers.h>
#include <difusa/version.h>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace difusa {

namespace {

using Json = nlohmann::ordered_json;

constexpr int as_float = 5126, as_short = 5123, as_index = 5125; ///< unsigned ones
constexpr int vertices = 34962, indices = 34963;                 ///< what a buffer view is for

/// The name of an attribute that glTF does not define: "_RADIOSITY"; with a number where it has been taken.
std::string attribute_name(const std::string& array, const Json& taken) {
    std::string name = "_";
    for (const char c : array) {
        const auto byte = static_cast<unsigned char>(c);
        name += std::isalnum(byte) != 0 ? static_cast<char>(std::toupper(byte)) : '_';
    }
    std::string unique = name;
    for (int number = 2; taken.contains(unique); ++number) {
        unique = name + "_" + std::to_string(number);
    }
    return unique;
}

/// The arrays of the buffer, one after the other, and what describes them. Sizes are multiples of four bytes.
class Arrays {
  public:
    /// Returns the number of the accessor. `put` writes all that the bytes are.
    std::size_t add(const char* type, int component, std::size_t count, std::size_t bytes, int target,
                    std::function<void(ByteStream&)> put) {
        views_.push_back({{"buffer", 0}, {"byteOffset", bytes_}, {"byteLength", bytes}, {"target", target}});
        accessors_.push_back(
            {{"bufferView", views_.size() - 1}, {"componentType", component}, {"count", count}, {"type", type}});
        bytes_ += bytes;
        puts_.push_back(std::move(put));
        return accessors_.size() - 1;
    }
    /// The accessor added last.
    Json& last() { return accessors_.back(); }

    std::size_t bytes() const { return bytes_; }
    void describe(Json& root) const {
        root["buffers"] = Json::array({{{"byteLength", bytes_}}});
        root["bufferViews"] = views_;
        root["accessors"] = accessors_;
    }
    void put(ByteStream& stream) const {
        for (const auto& each : puts_) {
            each(stream);
        }
    }

  private:
    Json views_ = Json::array(), accessors_ = Json::array();
    std::size_t bytes_ = 0;
    std::vector<std::function<void(ByteStream&)>> puts_;
};

void put_vector(ByteStream& stream, const Vec3& x) {
    for (const double component : x) {
        stream.put(static_cast<float>(component));
    }
}

/// Positions relative to the middle, in single precision, and their bounds, which glTF wants to be exact.
std::size_t add_positions(const FieldFile& field, const Vec3& middle, Arrays& arrays) {
    const std::size_t number = arrays.add("VEC3", as_float, field.points.size(), 12 * field.points.size(), vertices,
                                          [&field, middle](ByteStream& stream) {
                                              for (const Vec3& x : field.points) {
                                                  put_vector(stream, x - middle);
                                              }
                                          });
    std::array<float, 3> low, high;
    low.fill(std::numeric_limits<float>::max());
    high.fill(std::numeric_limits<float>::lowest());
    for (const Vec3& x : field.points) {
        for (std::size_t k = 0; k < 3; ++k) {
            const auto each = static_cast<Eigen::Index>(k);
            low[k] = std::min(low[k], static_cast<float>(x[each] - middle[each]));
            high[k] = std::max(high[k], static_cast<float>(x[each] - middle[each]));
        }
    }
    arrays.last()["min"] = low;
    arrays.last()["max"] = high;
    return number;
}

/// Bytes of sRGB as linear colours of 16 bits, opaque.
std::size_t add_colours(const std::vector<std::uint8_t>& bytes, Arrays& arrays) {
    const std::size_t count = bytes.size() / 3;
    const std::size_t number = arrays.add("VEC4", as_short, count, 8 * count, vertices, [&bytes](ByteStream& stream) {
        std::array<std::uint16_t, 256> linear{};
        for (std::size_t k = 0; k < linear.size(); ++k) {
            const double value = static_cast<double>(k) / static_cast<double>(linear.size() - 1);
            linear[k] = static_cast<std::uint16_t>(std::lround(65535.0 * linear_of_srgb(value)));
        }
        for (std::size_t k = 0; k < bytes.size(); ++k) {
            stream.put(linear[bytes[k]]);
            if (k % 3 == 2) {
                stream.put(std::uint16_t{65535});
            }
        }
    });
    arrays.last()["normalized"] = true;
    return number;
}

/// Real numbers, of up to four components.
std::size_t add_values(const Values& values, Arrays& arrays) {
    constexpr std::array<const char*, 4> types{"SCALAR", "VEC2", "VEC3", "VEC4"};
    const auto count = static_cast<std::size_t>(values.rows()), width = static_cast<std::size_t>(values.cols());
    return arrays.add(types[width - 1], as_float, count, 4 * width * count, vertices, [&values](ByteStream& stream) {
        for (Eigen::Index i = 0; i < values.rows(); ++i) {
            for (Eigen::Index c = 0; c < values.cols(); ++c) {
                stream.put(static_cast<float>(values(i, c)));
            }
        }
    });
}

Json primitive_of(const FieldFile& field, const Vec3& middle, Arrays& arrays) {
    Json attributes;
    attributes["POSITION"] = add_positions(field, middle, arrays);
    if (!field.normals.empty()) {
        attributes["NORMAL"] = arrays.add("VEC3", as_float, field.normals.size(), 12 * field.normals.size(), vertices,
                                          [&field](ByteStream& stream) {
                                              for (const Vec3& normal : field.normals) {
                                                  put_vector(stream, normal);
                                              }
                                          });
    }
    for (const FieldArray& array : field.point_arrays) {
        const Values* const values = values_of(array);
        if (array.name == field.active_colours && !array.name.empty()) {
            attributes["COLOR_0"] = add_colours(std::get<std::vector<std::uint8_t>>(array.data), arrays);
        } else if (values != nullptr && values->cols() <= 4) {
            attributes[attribute_name(array.name, attributes)] = add_values(*values, arrays);
            arrays.last()["name"] = array.name;
        }
    }
    Json primitive{{"attributes", attributes}, {"material", 0}, {"mode", field.triangles.empty() ? 0 : 4}};
    if (!field.triangles.empty()) {
        primitive["indices"] = arrays.add("SCALAR", as_index, 3 * field.triangles.size(), 12 * field.triangles.size(),
                                          indices, [&field](ByteStream& stream) {
                                              for (const auto& triangle : field.triangles) {
                                                  for (const Index corner : triangle) {
                                                      stream.put(std::uint32_t{corner});
                                                  }
                                              }
                                          });
    }
    return primitive;
}

Json notes_of(const FieldFile& field) {
    Json notes = Json::object();
    for (const FieldNote& note : field.notes) {
        std::visit([&](const auto& value) { notes[note.name] = value; }, note.value);
    }
    return notes;
}

/// +Y is up in glTF.
Json node_of(const FieldFile& field, const Vec3& middle) {
    const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(field.up, Vec3::UnitY());
    const Vec3 moved = turn * middle;
    return {{"name", "baked"},
            {"mesh", 0},
            {"rotation", {turn.x(), turn.y(), turn.z(), turn.w()}},
            {"translation", {moved.x(), moved.y(), moved.z()}}};
}

Vec3 middle_of(const std::vector<Vec3>& points) {
    Eigen::AlignedBox3d box;
    for (const Vec3& x : points) {
        box.extend(x);
    }
    return box.center();
}

} // namespace

void write_glb(const FieldFile& field, WholeFile& file, const Execution& /*execution*/) {
    DIFUSA_REQUIRE(!field.points.empty());
    const Vec3 middle = middle_of(field.points);
    Arrays arrays;
    Json root;
    root["asset"] = {{"version", "2.0"}, {"generator", "difusa " + version()}, {"extras", notes_of(field)}};
    root["extensionsUsed"] = {"KHR_materials_unlit"};
    root["scene"] = 0;
    root["scenes"] = Json::array({{{"nodes", {0}}}});
    root["nodes"] = Json::array({node_of(field, middle)});
    root["materials"] = Json::array({{{"name", "baked light"},
                                      {"pbrMetallicRoughness", {{"metallicFactor", 0.0}, {"roughnessFactor", 1.0}}},
                                      {"extensions", {{"KHR_materials_unlit", Json::object()}}}}});
    root["meshes"] =
        Json::array({{{"name", "baked"}, {"primitives", Json::array({primitive_of(field, middle, arrays)})}}});
    arrays.describe(root);
    std::string text = root.dump(-1, ' ', false, Json::error_handler_t::replace);
    text.append((4 - text.size() % 4) % 4, ' ');
    constexpr std::size_t headers = 12 + 8 + 8;
    const std::size_t size = headers + text.size() + arrays.bytes();
    if (size > std::numeric_limits<std::uint32_t>::max()) {
        throw ResourceError("a .glb holds at most 4 GiB, and this one would have " + std::to_string(size >> 30U) +
                            ": give a larger --output-spacing, or write a .vtp");
    }
    ByteStream stream(file);
    const auto put_word = [&](std::size_t word) { stream.put(static_cast<std::uint32_t>(word)); };
    put_word(0x46546c67); // "glTF"
    put_word(2);
    put_word(size);
    put_word(text.size());
    put_word(0x4e4f534a); // "JSON"
    for (const char c : text) {
        stream.put(c);
    }
    put_word(arrays.bytes());
    put_word(0x004e4942); // "BIN"
    arrays.put(stream);
    stream.flush();
}

} // namespace difusa
