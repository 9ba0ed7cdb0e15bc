#include <difusa/repair/soup_check.h>

#include <difusa/core/error.h>
#include <difusa/core/text.h>
#include <difusa/repair/findings.h>
#include <difusa/repair/texture_coordinates.h>

#include <cmath>
#include <sstream>

namespace difusa {

namespace {

/// Areas are products of two lengths, and are later multiplied and squared again.
constexpr double largest_coordinate = 1e75;

bool is_reflectance(const Rgb& rho) {
    return (rho >= 0.0).all() && (rho <= 1.0).all(); // false for NaN
}

std::string channels(const Rgb& colour) {
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text << colour[0] << ", " << colour[1] << ", " << colour[2];
    return text.str();
}

/// Guaranteed by every reader.
void check_shape(const PolygonSoup& soup) {
    DIFUSA_REQUIRE(!soup.first_corner.empty() && soup.first_corner.front() == 0 &&
                   soup.first_corner.back() == soup.corners.size());
    const std::size_t faces = soup.face_count();
    DIFUSA_REQUIRE(soup.face_material.size() == faces);
    DIFUSA_REQUIRE(soup.corner_texture.empty() || soup.corner_texture.size() == soup.corners.size());
    DIFUSA_REQUIRE(soup.point_reflectance.empty() || soup.point_reflectance.size() == soup.points.size());
    for (std::size_t f = 0; f < faces; ++f) {
        DIFUSA_REQUIRE(soup.first_corner[f] <= soup.first_corner[f + 1], "face " + std::to_string(f));
        const Index material = soup.face_material[f];
        DIFUSA_REQUIRE(material == none || material < soup.materials.size(), "face " + std::to_string(f));
        DIFUSA_REQUIRE(material == none || !soup.materials[material].vertex_colours || !soup.point_reflectance.empty(),
                       "face " + std::to_string(f));
    }
    if (soup.points.size() >= none || faces >= none || soup.corners.size() >= none / 3) {
        throw ResourceError(soup.file + ": has " + std::to_string(soup.corners.size()) +
                            " face corners, more than the limit of 1.4e9. Split the file.");
    }
}

void check_material(const PolygonSoup& soup, std::size_t face) {
    const Material& material = soup.materials[soup.face_material[face]];
    if (!material.vertex_colours && !is_reflectance(material.reflectance)) {
        throw InputError(
            file_prefix(soup, 0) + "material \"" + material.name + "\", used by " + face_name(soup, face) +
            ", has the reflectance (" + channels(material.reflectance) +
            "). A surface reflects between none (0) and all (1) of the light in each channel: correct it.");
    }
    if (material.reflectance_texture) {
        const Rgb most = (material.vertex_colours ? Rgb(Rgb::Ones()) : material.reflectance) *
                         material.reflectance_texture->brightest();
        if (!is_reflectance(most)) {
            throw InputError(file_prefix(soup, 0) + "material \"" + material.name + "\", used by " +
                             face_name(soup, face) + ", has a texture that takes the reflectance up to (" +
                             channels(most) +
                             "). A surface cannot reflect more than all (1) of the light: dim the "
                             "image, or its factor.");
        }
    }
    const Rgb diffuse = material.vertex_colours ? Rgb(Rgb::Zero()) : material.brightest_reflectance();
    if (!(material.mirror >= 0.0).all() || !material.reflects_at_most_all(diffuse)) {
        throw InputError(
            file_prefix(soup, 0) + "material \"" + material.name + "\", used by " + face_name(soup, face) +
            ", reflects (" + channels(diffuse) + ") diffusely and (" + channels(material.mirror) +
            ") as a mirror. A surface cannot reflect more than all (1) of the light: correct one of them.");
    }
    if (!((material.emission >= 0.0).all() && material.emission.isFinite().all())) {
        throw InputError(file_prefix(soup, 0) + "material \"" + material.name + "\", used by " + face_name(soup, face) +
                         ", has the emission (" + channels(material.emission) +
                         "). Emitted radiosity must be finite and non-negative: correct it.");
    }
}

void check_index(const PolygonSoup& soup, std::size_t face, Index corner) {
    if (corner >= soup.points.size()) {
        const std::string named =
            corner == none ? "a point before the first" : "point " + std::to_string(corner) + " (counting from 0)";
        throw InputError(
            face_prefix(soup, face) + face_name(soup, face) + " refers to " + named + ", but the file has " +
            std::to_string(soup.points.size()) +
            " points. Correct the number or remove the face; if points are missing, export the file again.");
    }
}

void check_corner(const PolygonSoup& soup, std::size_t face, Index corner) {
    check_index(soup, face, corner);
    const Vec3& point = soup.points[corner];
    if (!point.allFinite()) {
        throw InputError(face_prefix(soup, face) + point_name(soup, corner) + ", a corner of " + face_name(soup, face) +
                         ", is at " + coordinates(point) +
                         ". Every coordinate must be a finite number: correct it, or remove the face.");
    }
    if (!(point.cwiseAbs().maxCoeff() <= largest_coordinate)) {
        throw InputError(face_prefix(soup, face) + point_name(soup, corner) + ", a corner of " + face_name(soup, face) +
                         ", is at " + coordinates(point) +
                         ". Areas of that size overflow: use a larger unit of length.");
    }
}

void check_texture(const PolygonSoup& soup, std::size_t face) {
    const Index material = soup.face_material[face];
    if (material == none || !is_textured(soup.materials[material])) {
        return;
    }
    for (std::size_t c = soup.first_corner[face]; c < soup.first_corner[face + 1]; ++c) {
        if (soup.corner_texture.empty() || !is_placed_on(soup.materials[material], soup.corner_texture[c])) {
            throw InputError(face_prefix(soup, face) + face_name(soup, face) +
                             " has no usable texture coordinates where its "
                             "material \"" +
                             soup.materials[material].name +
                             "\" has a texture: add them, or remove "
                             "the texture.");
        }
    }
}

} // namespace

void check_indices(const PolygonSoup& soup) {
    for (std::size_t f = 0; f < soup.face_count(); ++f) {
        for (const Index corner : soup.face(f)) {
            check_index(soup, f, corner);
        }
    }
}

void check_soup(const PolygonSoup& soup) {
    check_shape(soup);
    std::vector<char> material_checked(soup.materials.size(), 0);
    for (std::size_t f = 0; f < soup.face_count(); ++f) {
        const Index material = soup.face_material[f];
        if (material != none && material_checked[material] == 0) {
            check_material(soup, f);
            material_checked[material] = 1;
        }
        check_texture(soup, f);
        const bool coloured = soup.painted(f);
        for (const Index corner : soup.face(f)) {
            check_corner(soup, f, corner);
            if (coloured && !is_reflectance(soup.point_reflectance[corner])) {
                throw InputError(face_prefix(soup, f) + point_name(soup, corner) + ", a corner of " +
                                 face_name(soup, f) + " at " + coordinates(soup.points[corner]) + ", has the colour (" +
                                 channels(soup.point_reflectance[corner]) + ")" +
                                 (material == none ? "" : " (material \"" + soup.materials[material].name + "\")") +
                                 ". Vertex colours are reflectances in [0,1]: correct it.");
            }
        }
    }
}

} // namespace difusa
