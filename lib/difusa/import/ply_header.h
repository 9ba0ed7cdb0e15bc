// The header of a PLY file: the elements that follow, and their properties.
#pragma once

#include <difusa/import/text_scanner.h>

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace difusa::ply {

enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };
enum class Format { text, little_endian, big_endian };

/// The role of a property in a mesh: a coordinate, a component of a colour, the corners of a face, or nothing.
enum Role : std::size_t { x, y, z, red, green, blue, alpha, value_count, corners = value_count, nothing };

struct Property {
    std::string name;
    Type type = Type::float32;           ///< of the value, or of the list's entries
    std::optional<Type> count_type = {}; ///< of the list's length, if it is a list
    Role role = nothing;
};

struct Element {
    enum class Kind { points, faces, strips, other };
    std::string name;
    Kind kind = Kind::other;
    std::size_t count = 0;
    std::vector<Property> properties;

    bool has(Role role) const {
        return std::any_of(properties.begin(), properties.end(), [role](const Property& p) { return p.role == role; });
    }
};

struct Header {
    Format format = Format::text;
    std::vector<Element> elements;
    std::size_t bytes = 0; ///< of the header with its last line end; only for the binary formats
};

/// Bytes of one value in a binary file.
constexpr std::size_t size_of(Type type) {
    constexpr std::size_t sizes[]{1, 1, 2, 2, 4, 4, 4, 8};
    return sizes[static_cast<std::size_t>(type)];
}

constexpr bool is_real(Type type) {
    return type == Type::float32 || type == Type::float64;
}

/// Reads the header of `content` with a scanner at its start, which is left after the word `end_header`.
/// No role occurs twice in an element. Throws InputError, naming the line, if the header is malformed or announces no
/// points with x, y and z, faces or strips without corners, or (if a `surface` is required) neither of them.
Header parse_header(std::string_view content, TextScanner& scanner, bool surface = true);

} // namespace difusa::ply
