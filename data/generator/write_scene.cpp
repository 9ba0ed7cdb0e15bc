#include "write_scene.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <stdexcept>

namespace scenes {

namespace {

std::string number(double value) {
    char buffer[32];
    std::snprintf(buffer, sizeof buffer, "%.9g", value);
    // Rounding noise around zero, such as the cosine of a right angle, becomes zero.
    return std::abs(value) < 1e-12 ? "0" : buffer;
}

std::string triple(double a, double b, double c) {
    return number(a) + " " + number(b) + " " + number(c);
}

std::string triple(const Colour& c) {
    return triple(c.r, c.g, c.b);
}

std::string remarks(const Surface& surface, const std::string& mark) {
    std::string text;
    for (const std::string& remark : surface.remarks) {
        text.append(mark).append(remark).append("\n");
    }
    return text;
}

void refuse_emission(const Surface& surface) {
    for (const Material& material : surface.materials) {
        if (material.emission.r > 0.0 || material.emission.g > 0.0 || material.emission.b > 0.0) {
            throw std::logic_error("this file format has no emission");
        }
    }
}

/// A JSON string.
std::string quoted(const std::string& text) {
    std::string result = "\"";
    for (const char c : text) {
        result += c == '"' || c == '\\' ? std::string{'\\', c} : std::string{c};
    }
    return result + "\"";
}

/// A JSON list of three numbers, alone or as the entry `name`.
std::string list(double a, double b, double c) {
    return "[" + number(a) + ", " + number(b) + ", " + number(c) + "]";
}

std::string entry(const std::string& name, const Vector& v) {
    return quoted(name) + ": " + list(v.x, v.y, v.z);
}

std::string entry(const std::string& name, const Colour& c) {
    return quoted(name) + ": " + list(c.r, c.g, c.b);
}

/// The lines of a JSON list, inside its brackets.
std::string lines(const std::vector<std::string>& items) {
    std::string text;
    for (const std::string& item : items) {
        text += (text.empty() ? "\n    " : ",\n    ") + item;
    }
    return text + "\n  ";
}

/// The low bytes of a number, least significant first.
void append(std::string& bytes, std::uint32_t bits, int count) {
    for (int i = 0; i < count; ++i) {
        bytes.push_back(static_cast<char>((bits >> (8 * i)) & 0xffU));
    }
}

std::uint32_t byte(double share) {
    return static_cast<std::uint32_t>(std::lround(255.0 * share));
}

} // namespace

void write_text(const std::string& content, const std::filesystem::path& file) {
    std::ofstream stream(file, std::ios::binary);
    stream << content;
    stream.close();
    if (!stream) {
        throw std::runtime_error(file.string() + ": cannot be written");
    }
}

void write_obj(const Surface& surface, const std::filesystem::path& directory, const std::string& name) {
    const auto is_mirror = [](const Material& material) {
        return material.mirror.r > 0.0 || material.mirror.g > 0.0 || material.mirror.b > 0.0;
    };
    std::string library = remarks(surface, "# ") + "# Kd: reflectance. Ke: emitted radiosity, W/m^2.";
    const bool glossy = std::any_of(surface.materials.begin(), surface.materials.end(),
                                    [](const Material& material) { return material.exponent > 0.0; });
    const bool mirrors = std::any_of(surface.materials.begin(), surface.materials.end(), is_mirror);
    library += glossy    ? " Ks with illum 3: reflectance of a Phong lobe of the exponent Ns.\n"
               : mirrors ? " Ks with illum 3: reflectance of a mirror.\n"
                         : "\n";
    for (const Material& material : surface.materials) {
        library += "\nnewmtl " + material.name + "\nKd " + triple(material.reflectance) + "\nKe " +
                   triple(material.emission) + "\n";
        if (is_mirror(material)) {
            library += "Ks " + triple(material.mirror) + "\n" +
                       (material.exponent > 0.0 ? "Ns " + number(material.exponent) + "\n" : "") + "illum 3\n";
        }
    }
    write_text(library, directory / (name + ".mtl"));

    std::string text = remarks(surface, "# ") + "mtllib " + name + ".mtl\n";
    for (const Vector& p : surface.points()) {
        text += "v " + triple(p.x, p.y, p.z) + "\n";
    }
    const Face* before = nullptr;
    for (const Face& face : surface.faces()) {
        if (before == nullptr || face.material != before->material) {
            text += "usemtl " + surface.materials[face.material].name + "\n";
        }
        before = &face;
        text += "f";
        for (const unsigned corner : face.corners) {
            text += " " + std::to_string(corner + 1);
        }
        text += "\n";
    }
    write_text(text, directory / (name + ".obj"));
}

void write_scene(const Scene& scene, const std::filesystem::path& directory, const std::string& name) {
    write_obj(scene.surface, directory, name);

    std::vector<std::string> comment, lights;
    for (const std::string& remark : scene.surface.remarks) {
        comment.push_back(quoted(remark));
    }
    for (const Sun& sun : scene.suns) {
        lights.push_back(R"({"type": "sun", "name": "sun", )" + entry("towards", sun.towards) + ", " +
                         entry("irradiance", sun.irradiance) + "}");
    }
    for (const PointLight& point : scene.points) {
        lights.push_back(R"({"type": "point", "name": "lamp", )" + entry("position", point.position) + ", " +
                         entry("intensity", point.intensity) + "}");
    }
    std::vector<std::string> names, materials;
    for (const Material& material : scene.surface.materials) {
        if (!material.thermal.empty()) {
            names.push_back(quoted(material.name) + ": " + quoted(material.name));
            materials.push_back(quoted(material.name) + ": {" + material.thermal + "}");
        }
    }
    std::string text = "{\n  \"difusa_scene\": 1,\n  \"comment\": [" + lines(comment) + "],\n  \"unit\": \"m\",\n" +
                       "  \"up\": \"" + scene.up + "\",\n  \"meshes\": [{\"file\": \"" + name + ".obj\"";
    if (!materials.empty()) {
        text += ", \"materials\": {" + lines(names) + "}}],\n  \"materials\": {" + lines(materials) + "},\n";
    } else {
        text += "}],\n";
    }
    if (!lights.empty()) {
        text += "  \"lights\": [" + lines(lights) + "],\n";
    }
    if (scene.sky) {
        text += R"(  "sky": {"type": "gradient", )" + entry("zenith", scene.sky->zenith) + ", " +
                entry("horizon", scene.sky->horizon) + ", " + entry("ground", scene.sky->ground) + "},\n";
    }
    std::vector<std::string> planes, periods;
    for (const SymmetryPlane& plane : scene.symmetry) {
        planes.push_back("{" + entry("point", plane.point) + ", " + entry("normal", plane.normal) + "}");
    }
    for (const Vector& translation : scene.periodic) {
        periods.push_back("{" + entry("translation", translation) + "}");
    }
    if (!planes.empty()) {
        text += "  \"symmetry\": [" + lines(planes) + "],\n";
    }
    if (!periods.empty()) {
        text += "  \"periodic\": [" + lines(periods) + "],\n";
    }
    text += "  \"camera\": {" + entry("eye", scene.camera.eye) + ", " + entry("look_at", scene.camera.look_at) +
            ", \"view_degrees\": " + number(scene.camera.view_degrees) + "}\n}\n";
    write_text(text, directory / (name + ".json"));
}

void write_off(const Surface& surface, const std::filesystem::path& directory, const std::string& name) {
    refuse_emission(surface);
    std::string text = "OFF\n" + remarks(surface, "# ") + std::to_string(surface.points().size()) + " " +
                       std::to_string(surface.faces().size()) + " 0\n";
    for (const Vector& p : surface.points()) {
        text += triple(p.x, p.y, p.z) + "\n";
    }
    for (const Face& face : surface.faces()) {
        text += std::to_string(face.corners.size());
        for (const unsigned corner : face.corners) {
            text += " " + std::to_string(corner);
        }
        text += "  " + triple(surface.materials[face.material].reflectance) + "\n";
    }
    write_text(text, directory / (name + ".off"));
}

void write_ply(const Surface& surface, const std::filesystem::path& directory, const std::string& name) {
    refuse_emission(surface);
    std::string bytes = "ply\nformat binary_little_endian 1.0\n" + remarks(surface, "comment ") + "element vertex " +
                        std::to_string(surface.points().size()) +
                        "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
                        std::to_string(surface.faces().size()) +
                        "\nproperty list uchar int vertex_indices\nproperty uchar red\nproperty uchar green\n"
                        "property uchar blue\nend_header\n";
    for (const Vector& p : surface.points()) {
        for (const double coordinate : {p.x, p.y, p.z}) {
            const float single = std::abs(coordinate) < 1e-12 ? 0.0F : static_cast<float>(coordinate);
            append(bytes, std::bit_cast<std::uint32_t>(single), 4);
        }
    }
    for (const Face& face : surface.faces()) {
        append(bytes, static_cast<std::uint32_t>(face.corners.size()), 1);
        for (const unsigned corner : face.corners) {
            append(bytes, corner, 4);
        }
        const Colour& c = surface.materials[face.material].reflectance;
        append(bytes, byte(c.r) | byte(c.g) << 8U | byte(c.b) << 16U, 3);
    }
    write_text(bytes, directory / (name + ".ply"));
}

} // namespace scenes
