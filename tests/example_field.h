// A field for the tests of its readers and writers.
#pragma once

#include <difusa/io/field_file.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "meshes.h"

namespace difusa::test {

/// Values whose bits all matter, and the ones that are easily lost.
inline Values awkward_values(std::size_t rows, int columns) {
    Values values(static_cast<Eigen::Index>(rows), columns);
    for (Eigen::Index i = 0; i < values.size(); ++i) {
        values.data()[i] = std::sin(1.0 + static_cast<double>(i)) * std::pow(10.0, static_cast<double>(i % 37) - 18.0);
    }
    values.data()[0] = -0.0;
    values.data()[1] = std::numeric_limits<double>::denorm_min();
    values.data()[2] = 1e150; // beyond, VTK's reader stumbles over the infinite norm it wrote itself
    return values;
}

/// A ball with arrays and notes of every kind.
inline FieldFile example_field(int level, const std::string& unit_of_luminance) {
    const Mesh mesh = icosphere(level, 1e6 / 3);
    const std::size_t points = mesh.points.size(), triangles = mesh.triangles.size();
    FieldFile field;
    field.points = mesh.points;
    field.triangles = mesh.triangles;
    for (const Vec3& point : mesh.points) {
        field.normals.push_back(point.normalized());
    }
    field.point_arrays.push_back({"radiosity", "W/m^2", {"R", "G", "B"}, awkward_values(points, 3)});
    field.point_arrays.push_back({"luminance", unit_of_luminance, {}, awkward_values(points, 1)});
    std::vector<std::uint8_t> colours(3 * points);
    for (std::size_t i = 0; i < colours.size(); ++i) {
        colours[i] = static_cast<std::uint8_t>(i);
    }
    field.point_arrays.push_back({"display_rgb", "", {"R", "G", "B"}, colours});
    std::vector<std::int32_t> faces(triangles);
    for (std::size_t i = 0; i < triangles; ++i) {
        faces[i] = static_cast<std::int32_t>(i) * 1'000'003 - 7;
    }
    field.cell_arrays.push_back({"original_face_id", "", {}, faces});
    field.active_colours = "display_rgb";
    field.notes = {{"version", "1.2.3"},
                   {"options", "--reflectance 0.5,<0.4>&\"x\" 'y' ρ\nsecond line"},
                   {"empty", ""},
                   {"residuals", std::vector<double>{1.0, 0.1, 1e-17, 1.0 / 3}}};
    return field;
}

} // namespace difusa::test
