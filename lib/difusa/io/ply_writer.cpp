// Positions are doubles, which MeshLab, ParaView and Blender all read: a small detail far from the origin would
// collapse in floats. Normals and quality are floats because MeshLab stores them so, and colours are bytes because it
// shows float colours as white.
#include <difusa/io/byte_stream.h>
#include <difusa/io/field_writers.h>

#include <difusa/core/error.h>
#include <difusa/core/text.h>

#include <algorithm>
#include <limits>

namespace difusa {

namespace {

/// A note as header lines. Readers hold a line in a fixed-size buffer, so long ones continue in the next; and a line
/// break inside a note would end the comment.
std::string comment(std::string text) {
    constexpr std::size_t longest = 200;
    for (char& c : text) {
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
            c = ' ';
        }
    }
    std::string lines;
    do {
        std::size_t length = std::min(text.size(), longest);
        const auto continues_character = [&](std::size_t i) {
            return i < text.size() && (static_cast<unsigned char>(text[i]) & 0xc0) == 0x80; // UTF-8
        };
        while (length > longest - 3 && continues_character(length)) {
            --length;
        }
        lines += "comment " + text.substr(0, length) + "\n";
        text.erase(0, length);
    } while (!text.empty());
    return lines;
}

std::string note_text(const FieldNote& note) {
    if (const std::string* text = std::get_if<std::string>(&note.value)) {
        return *text;
    }
    std::string numbers;
    for (const double value : std::get<std::vector<double>>(note.value)) {
        numbers += (numbers.empty() ? "" : " ") + exact_text(value);
    }
    return numbers;
}

const FieldArray* find(const FieldFile& field, const std::string& name) {
    const auto place = std::find_if(field.point_arrays.begin(), field.point_arrays.end(),
                                    [&](const FieldArray& array) { return !name.empty() && array.name == name; });
    return place == field.point_arrays.end() ? nullptr : &*place;
}

} // namespace

void write_ply(const FieldFile& field, WholeFile& file, const Execution& /*execution*/) {
    DIFUSA_REQUIRE(field.points.size() <= static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()));
    const FieldArray* colours = find(field, field.active_colours);
    const FieldArray* quality = find(field, field.quality);

    std::string header = "ply\nformat binary_little_endian 1.0\n";
    for (const FieldNote& note : field.notes) {
        header += comment(note.name + ": " + note_text(note));
    }
    if (quality != nullptr) {
        header += comment("quality: " + quality->name + (quality->unit.empty() ? "" : " in " + quality->unit));
    }
    header += "element vertex " + std::to_string(field.points.size()) + "\n";
    header += "property double x\nproperty double y\nproperty double z\n";
    if (!field.normals.empty()) {
        header += "property float nx\nproperty float ny\nproperty float nz\n";
    }
    if (colours != nullptr) {
        header += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    }
    if (quality != nullptr) {
        header += "property float quality\n";
    }
    if (!field.triangles.empty()) {
        header += "element face " + std::to_string(field.triangles.size()) + "\n";
        header += "property list uchar int vertex_indices\n";
    }
    file.write(header + "end_header\n");

    ByteStream bytes(file);
    for (std::size_t p = 0; p < field.points.size(); ++p) {
        for (const double coordinate : field.points[p]) {
            bytes.put(coordinate);
        }
        if (!field.normals.empty()) {
            for (const double component : field.normals[p]) {
                bytes.put(static_cast<float>(component));
            }
        }
        if (colours != nullptr) {
            for (std::size_t k = 0; k < 3; ++k) {
                bytes.put(std::get<std::vector<std::uint8_t>>(colours->data)[3 * p + k]);
            }
        }
        if (quality != nullptr) {
            bytes.put(static_cast<float>((*values_of(*quality))(static_cast<Eigen::Index>(p), 0)));
        }
    }
    for (const auto& triangle : field.triangles) {
        bytes.put(std::uint8_t{3});
        for (const Index corner : triangle) {
            bytes.put(static_cast<std::int32_t>(corner));
        }
    }
    bytes.flush();
}

} // namespace difusa
