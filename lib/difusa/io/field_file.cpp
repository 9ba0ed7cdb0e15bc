#include <difusa/io/field_file.h>

#include <difusa/core/error.h>
#include <difusa/io/field_writers.h>

#include <algorithm>
#include <cctype>
#include <sstream>

namespace difusa {

namespace {

namespace fs = std::filesystem;

using Writer = void (*)(const FieldFile&, WholeFile&, const Execution&);

Writer writer_for(const fs::path& file) {
    std::string extension = file.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (extension == ".vtp") {
        return write_vtp;
    }
    if (extension == ".ply") {
        return write_ply;
    }
    if (extension == ".glb") {
        return write_glb;
    }
    throw UsageError(
        "cannot write a field to `" + file.string() +
        "`: the name must end in .vtp (ParaView, everything), .ply (MeshLab, colours and quality) or .glb (glTF, "
        "colours and values)");
}

void require_array(const FieldArray& array, std::size_t rows) {
    const std::size_t columns = std::max<std::size_t>(1, array.components.size());
    if (const Values* values = values_of(array)) {
        DIFUSA_REQUIRE(static_cast<std::size_t>(values->rows()) == rows, array.name);
        DIFUSA_REQUIRE(static_cast<std::size_t>(values->cols()) == columns, array.name);
    } else if (const auto* bytes = std::get_if<std::vector<std::uint8_t>>(&array.data)) {
        DIFUSA_REQUIRE(bytes->size() == rows * columns, array.name);
    } else {
        DIFUSA_REQUIRE(std::get<std::vector<std::int32_t>>(array.data).size() == rows * columns, array.name);
    }
}

void require_consistent(const FieldFile& field) {
    DIFUSA_REQUIRE(field.normals.empty() || field.normals.size() == field.points.size());
    for (const auto& triangle : field.triangles) {
        for (const Index corner : triangle) {
            DIFUSA_REQUIRE(corner < field.points.size());
        }
    }
    for (const FieldArray& array : field.point_arrays) {
        require_array(array, field.points.size());
    }
    for (const FieldArray& array : field.cell_arrays) {
        require_array(array, field.triangles.empty() ? field.points.size() : field.triangles.size());
    }
    const auto among_points = [&](const std::string& name, auto fits) {
        return name.empty() || std::any_of(field.point_arrays.begin(), field.point_arrays.end(),
                                           [&](const FieldArray& a) { return a.name == name && fits(a); });
    };
    DIFUSA_REQUIRE(among_points(field.active_colours,
                                [](const FieldArray& array) {
                                    return array.components.size() == 3 &&
                                           std::holds_alternative<std::vector<std::uint8_t>>(array.data);
                                }),
                   field.active_colours);
    DIFUSA_REQUIRE(among_points(field.quality,
                                [](const FieldArray& array) {
                                    return array.components.size() <= 1 && values_of(array) != nullptr;
                                }),
                   field.quality);
}

/// Throws InternalError if a number of this row is not finite. `kind`: "vertex" or "cell".
template <class Row>
void require_finite(const std::string& array, const char* kind, std::size_t number, const Row& row) {
    if (!row.allFinite()) {
        std::ostringstream text;
        text << "`" << array << "` of " << kind << " " << number << " is " << row
             << ": not a result. Nothing is written; please report this with the scene and the options";
        throw InternalError(text.str());
    }
}

void require_finite(const std::string& array, const char* kind, const std::vector<Vec3>& vectors) {
    for (std::size_t i = 0; i < vectors.size(); ++i) {
        require_finite(array, kind, i, vectors[i].transpose());
    }
}

void require_finite(const std::vector<FieldArray>& arrays, const char* kind) {
    for (const FieldArray& array : arrays) {
        if (const Values* values = values_of(array)) {
            for (Eigen::Index i = 0; i < values->rows(); ++i) {
                require_finite(array.name, kind, static_cast<std::size_t>(i), values->row(i));
            }
        }
    }
}

} // namespace

void require_finite(const FieldFile& field) {
    require_finite("position", "vertex", field.points);
    require_finite("normal", "vertex", field.normals);
    require_finite(field.point_arrays, "vertex");
    require_finite(field.cell_arrays, "cell");
}

void write_field(const FieldFile& field, const fs::path& file, WholeFile& whole, const Execution& execution) {
    const Writer write = writer_for(file);
    require_consistent(field);
    write(field, whole, execution);
}

void write_finite_field(const FieldFile& field, const fs::path& file, WholeFile& whole, const Execution& execution) {
    require_finite(field);
    write_field(field, file, whole, execution);
}

void write_field(const FieldFile& field, const fs::path& file, const Execution& execution) {
    writer_for(file); // before a file is created
    WholeFile whole(file);
    write_field(field, file, whole, execution);
    whole.commit();
}

void check_output_path(const fs::path& file, bool field) {
    if (field) {
        writer_for(file);
    }
    const WholeFile probe(file); // removed again
}

} // namespace difusa
