#include <difusa/import/placement.h>

#include <difusa/core/error.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace difusa {

namespace {

template <class T> void move_to_end(std::vector<T>& all, std::vector<T>& more) {
    all.insert(all.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

/// Appends a list with one entry for each of `count`, or possibly empty (all are `nothing`).
template <class T>
void append_list(std::vector<T>& all, std::size_t before, std::vector<T>& more, std::size_t count, const T& nothing) {
    if (all.empty() && more.empty()) {
        return;
    }
    all.resize(before, nothing);
    more.resize(count, nothing);
    move_to_end(all, more);
}

} // namespace

Eigen::Matrix3d rotation(const Vec3& axis, double degrees) {
    const double turn = std::remainder(degrees, 360.0);
    double s = std::sin(turn * std::numbers::pi / 180.0), c = std::cos(turn * std::numbers::pi / 180.0);
    if (std::remainder(turn, 90.0) == 0.0) {
        s = std::round(s);
        c = std::round(c);
    }
    // Rodrigues' formula.
    const Vec3 n = axis.stableNormalized();
    Eigen::Matrix3d cross;
    cross << 0.0, -n.z(), n.y(), n.z(), 0.0, -n.x(), -n.y(), n.x(), 0.0;
    return c * Eigen::Matrix3d::Identity() + s * cross + (1.0 - c) * n * n.transpose();
}

void turn_over(PolygonSoup& soup) {
    for (std::size_t f = 0; f < soup.face_count(); ++f) {
        const auto begin = static_cast<std::ptrdiff_t>(soup.first_corner[f]) + 1;
        const auto end = static_cast<std::ptrdiff_t>(soup.first_corner[f + 1]);
        if (begin < end) {
            std::reverse(soup.corners.begin() + begin, soup.corners.begin() + end);
            if (!soup.corner_texture.empty()) {
                std::reverse(soup.corner_texture.begin() + begin, soup.corner_texture.begin() + end);
            }
        }
    }
}

void place(PolygonSoup& soup, const Placement& placement) {
    if (!placement.moves()) {
        return;
    }
    for (Vec3& point : soup.points) {
        point = placement(point);
    }
    if (placement.mirrors()) {
        turn_over(soup);
    }
    const auto turn = [&](Vec3& direction) { direction = (placement.linear * direction).stableNormalized(); };
    turn(soup.up);
    for (Sun& sun : soup.lights.suns) {
        turn(sun.towards);
    }
    for (PointLight& light : soup.lights.points) {
        light.position = placement(light.position);
        turn(light.direction);
        turn(light.c0);
        turn(light.c90);
    }
    if (soup.camera) {
        soup.camera->eye = placement(soup.camera->eye);
        turn(soup.camera->towards);
        turn(soup.camera->up);
    }
}

void append(PolygonSoup& soup, PolygonSoup part) {
    const std::size_t points = soup.points.size(), faces = soup.face_count(), corners = soup.corners.size();
    const std::size_t materials = soup.materials.size();
    if (points + part.points.size() >= none || corners + part.corners.size() >= none ||
        materials + part.materials.size() >= none) {
        throw ResourceError(part.file + ": with this mesh the scene " + soup.file +
                            " has more than 4e9 points or face corners: split it");
    }
    if (part.parts.empty()) {
        part.parts.push_back({part.file, 0, 0});
    }
    for (SoupPart& file : part.parts) {
        soup.parts.push_back(
            {std::move(file.file), file.first_face + faces, file.first_point + points, std::move(file.name)});
    }
    // Faces without a material may have vertex colours in one part and the default reflectance in another: the former
    // get a material that says so.
    if (part.faces_are_painted()) {
        Material painted;
        painted.name = "vertex colours";
        painted.vertex_colours = true;
        const auto number = static_cast<Index>(part.materials.size());
        part.materials.push_back(painted);
        std::replace(part.face_material.begin(), part.face_material.end(), none, number);
        for (Material& material : part.materials) {
            material.vertex_colours = material.vertex_colours || material.is_undefined;
            material.is_undefined = false;
        }
    }
    soup.colours_by_material = true;
    append_list(soup.point_reflectance, points, part.point_reflectance, part.points.size(), Rgb(Rgb::Constant(0.5)));
    append_list(soup.point_line, points, part.point_line, part.points.size(), std::uint32_t{0});
    append_list(soup.face_line, faces, part.face_line, part.face_count(), std::uint32_t{0});
    append_list(soup.corner_texture, corners, part.corner_texture, part.corners.size(), unplaced);
    move_to_end(soup.points, part.points);
    for (const Index corner : part.corners) {
        soup.corners.push_back(corner + static_cast<Index>(points));
    }
    for (std::size_t f = 1; f < part.first_corner.size(); ++f) {
        soup.first_corner.push_back(part.first_corner[f] + corners);
    }
    for (const Index material : part.face_material) {
        soup.face_material.push_back(material == none ? none : material + static_cast<Index>(materials));
    }
    move_to_end(soup.materials, part.materials);
    move_to_end(soup.lights.suns, part.lights.suns);
    move_to_end(soup.lights.points, part.lights.points);
    soup.camera = soup.camera ? soup.camera : part.camera;
    soup.photometric = soup.photometric || part.photometric;
    soup.default_reflectance = soup.default_reflectance ? soup.default_reflectance : part.default_reflectance;
    move_to_end(soup.files, part.files);
    for (const std::string& note : part.notes) {
        soup.notes.push_back(part.file + ": " + note);
    }
}

} // namespace difusa
