// What every reader of fields must hold to for any input: a field without contradictions, or an error.
#pragma once

#include "fuzz_file.h"

#include <difusa/io/field_readers.h>

#include <type_traits>
#include <variant>

namespace fuzz {

inline void check_rows(const std::vector<difusa::FieldArray>& arrays, std::size_t rows) {
    for (const difusa::FieldArray& array : arrays) {
        std::visit(
            [&](const auto& values) {
                std::size_t size = 0;
                if constexpr (std::is_same_v<std::decay_t<decltype(values)>, difusa::ValuesView>) {
                    size = static_cast<std::size_t>(values.get().size());
                } else {
                    size = static_cast<std::size_t>(values.size());
                }
                hold(rows == 0 ? size == 0 : size % rows == 0, "arrays have as many values for each row");
                hold(array.components.empty() || size == rows * array.components.size(), "all components have names");
            },
            array.data);
    }
}

inline void check(const difusa::FieldFile& field) {
    for (const difusa::Vec3& point : field.points) {
        hold(point.allFinite(), "coordinates are finite");
    }
    for (const auto& triangle : field.triangles) {
        for (const difusa::Index corner : triangle) {
            hold(corner < field.points.size(), "corners are points");
        }
    }
    hold(field.normals.empty() || field.normals.size() == field.points.size(), "normals for all points or none");
    check_rows(field.point_arrays, field.points.size());
    check_rows(field.cell_arrays, field.triangles.empty() ? field.points.size() : field.triangles.size());
}

} // namespace fuzz
