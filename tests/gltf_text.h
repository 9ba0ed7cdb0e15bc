// For tests of the reader `gltf`: files put together byte for byte.
#pragma once

#include <readers.h>

#include <bit>
#include <cstdint>
#include <initializer_list>
#include <string>

namespace gltf_text {

using difusa::PolygonSoup;
using readers::Bytes;

inline std::string base64(const std::string& bytes) {
    const char* const digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t bits = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            bits = bits << 8U | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
        }
        for (std::size_t k = 0; k < 4; ++k) {
            text += i + k > bytes.size() ? '=' : digits[bits >> (18 - 6 * k) & 63U];
        }
    }
    return text;
}

/// Collects arrays as buffer views and accessors of one buffer.
class Arrays {
  public:
    /// Returns the number of the accessor. `more`: further members, beginning with a comma.
    template <class T>
    std::size_t add(const char* type, int component, std::size_t count, std::initializer_list<T> values,
                    const std::string& more = {}) {
        while (data_.size() % 4 != 0) {
            data_ += '\0';
        }
        const std::string bytes = Bytes(std::endian::little).add(values).content();
        views_ += (views_.empty() ? "" : ",") + std::string("{\"buffer\":0,\"byteOffset\":") +
                  std::to_string(data_.size()) + ",\"byteLength\":" + std::to_string(bytes.size()) + "}";
        accessors_ += (accessors_.empty() ? "" : ",") + std::string("{\"bufferView\":") + std::to_string(count_) +
                      ",\"componentType\":" + std::to_string(component) + ",\"count\":" + std::to_string(count) +
                      ",\"type\":\"" + type + "\"" + more + "}";
        data_ += bytes;
        return count_++;
    }
    const std::string& data() const { return data_; }
    std::string members(const std::string& uri) const {
        return "\"accessors\":[" + accessors_ + "],\"bufferViews\":[" + views_ +
               "],\"buffers\":[{\"byteLength\":" + std::to_string(data_.size()) + uri + "}]";
    }
    std::string embedded() const {
        return members(",\"uri\":\"data:application/octet-stream;base64," + base64(data_) + "\"");
    }

  private:
    std::string data_, views_, accessors_;
    std::size_t count_ = 0;
};

/// A whole file; `members` follow one another with commas.
inline std::string file(const std::string& members) {
    return "{\"asset\":{\"version\":\"2.0\"},\n" + members + "}";
}

inline PolygonSoup gltf(const std::string& members) {
    return readers::parse("gltf", file(members));
}

inline std::string refused(const std::string& members) {
    return readers::refusal("gltf", file(members));
}

/// The unit square in z = 0, four vertices with texture coordinates, as indexed triangles: accessors 0, 1, 2.
inline Arrays square() {
    Arrays arrays;
    arrays.add<float>("VEC3", 5126, 4, {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});
    arrays.add<float>("VEC2", 5126, 4, {0, 1, 1, 1, 1, 0, 0, 0.25F});
    arrays.add<std::uint16_t>("SCALAR", 5123, 6, {0, 1, 2, 0, 2, 3});
    return arrays;
}

inline const std::string square_mesh =
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1},\"indices\":2,\"material\":0}]}]";

/// The square with these nodes and further members; material 0 is white paint.
inline std::string scene(const std::string& nodes, const std::string& more = {}) {
    return "\"scenes\":[{\"nodes\":[0]}],\"scene\":0,\"nodes\":[" + nodes +
           "],\"materials\":[{\"name\":\"paint\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.5,0.25,0.125,1],"
           "\"metallicFactor\":0}}]," +
           square_mesh + "," + square().embedded() + more;
}

} // namespace gltf_text
