// Unlike the mesh reader `ply`, this keeps all data at the points: normals, colours, quality and any other numbers.
#include <difusa/io/field_readers.h>

#include <difusa/import/file_content.h>
#include <difusa/import/ply_body.h>

#include <algorithm>
#include <cctype>

namespace difusa {

namespace {

using namespace ply;

// ---- elements -------------------------------------------------------------------------------------------------

/// The scalar properties of an element, and the lists of corners among them.
struct ElementTable {
    std::vector<std::string> names;
    std::vector<Type> types;
    std::vector<std::vector<double>> columns; ///< one for each name
    std::vector<std::vector<std::int64_t>> corners;

    const std::vector<double>* find(const std::string& name) const {
        const auto place = std::find(names.begin(), names.end(), name);
        return place == names.end() ? nullptr : &columns[static_cast<std::size_t>(place - names.begin())];
    }
    bool is_byte(const std::string& name) const {
        const auto place = std::find(names.begin(), names.end(), name);
        return place != names.end() && types[static_cast<std::size_t>(place - names.begin())] == Type::uint8;
    }
};

struct ElementTables {
    ElementTable points, faces, strips, others;

    ElementTable& of(Element::Kind kind) {
        return kind == Element::Kind::points   ? points
               : kind == Element::Kind::faces  ? faces
               : kind == Element::Kind::strips ? strips
                                               : others;
    }
};

/// Collects the rows of an element in a table.
template <class Values> class ElementTableSink {
  public:
    ElementTableSink(const Values& values, const Element& element, ElementTable& table)
        : values_(values), table_(table) {
        for (const Property& property : element.properties) {
            if (!property.count_type) {
                table_.names.push_back(property.name);
                table_.types.push_back(property.type);
            }
        }
        table_.columns.resize(table_.names.size());
    }

    static Expected expected(const Element& element, const Property& property, std::size_t row) {
        return {property.name.c_str(), row + 1, element.count};
    }
    static bool wants(const Property&) { return true; }

    void begin_row() { column_ = 0; }
    void value(const Property&, double value, const Expected&) { table_.columns[column_++].push_back(value); }
    void check_length(const Property& property, std::int64_t length, const Expected&) const {
        if (length < 0 || static_cast<double>(length) * Values::least_bytes(property.type) >
                              static_cast<double>(values_.available())) {
            values_.fail("a list '" + property.name + "' announces " + std::to_string(length) +
                         " entries, which is impossible: the file is damaged; write it again");
        }
    }
    void corners(const std::vector<std::int64_t>& list) { table_.corners.push_back(list); }
    void end_row() {}

  private:
    const Values& values_;
    ElementTable& table_;
    std::size_t column_ = 0;
};

void finish(TextScanner& scanner) {
    std::string_view token;
    if (scanner.next(token, TextScanner::Reach::file)) {
        scanner.fail("the file continues with " + excerpt(token) +
                     " after all its header announces: the file is damaged; write it again");
    }
}

void finish(const ByteScanner& scanner) {
    if (scanner.remaining() > 0) {
        scanner.fail("the file continues after all its header announces: the file is damaged; write it again");
    }
}

template <class Values> ElementTables read_tables(Values values, const Header& header) {
    if (least_bytes<Values>(header) > static_cast<double>(values.available())) {
        values.fail("the header announces more data than follow: the file is truncated or its header is wrong; write "
                    "it again");
    }
    ElementTables tables;
    for (const Element& element : header.elements) {
        ElementTable& table = tables.of(element.kind);
        table = {};
        ElementTableSink sink(values, element, table);
        read_rows(values, element, sink);
    }
    finish(values.scanner());
    return tables;
}

// ---- the field ------------------------------------------------------------------------------------------------

/// The comments of the header: "name: text", long ones continued in the next (ply_writer.cpp). Others have no name.
std::vector<FieldNote> notes_of(std::string_view header) {
    constexpr std::string_view mark = "comment ";
    constexpr std::size_t longest = 200;
    std::vector<FieldNote> notes;
    std::size_t last = 0; ///< length of the comment in the previous line
    while (!header.empty()) {
        const std::size_t end = std::min(header.find_first_of("\r\n"), header.size());
        const std::string_view line = header.substr(0, end);
        header.remove_prefix(std::min(end + 1, header.size()));
        if (!line.starts_with(mark)) {
            last = line.empty() ? last : 0;
            continue;
        }
        const std::string_view text = line.substr(mark.size());
        std::size_t name = 0;
        while (name < text.size() && (std::isalnum(static_cast<unsigned char>(text[name])) != 0 || text[name] == '_')) {
            ++name;
        }
        const bool named = name > 0 && text.substr(name).starts_with(": ");
        const bool full = last > longest - 4 && last <= longest;
        if (full && !notes.empty() && (!named || last < longest)) {
            std::get<std::string>(notes.back().value) += text;
        } else if (named) {
            notes.push_back({std::string(text.substr(0, name)), std::string(text.substr(name + 2))});
        } else {
            notes.push_back({"comment", std::string(text)});
        }
        last = text.size();
    }
    return notes;
}

/// The column of an array of one component: #rows by 1, row i from entry `row[i]`.
FieldArray scalar(const std::string& name, Type type, const std::vector<double>& column,
                  const std::vector<std::size_t>* row) {
    std::vector<double> chosen;
    for (std::size_t i = 0; row != nullptr && i < row->size(); ++i) {
        chosen.push_back(column[(*row)[i]]);
    }
    const std::vector<double>& values = row == nullptr ? column : chosen;
    const auto count = static_cast<Eigen::Index>(values.size());
    FieldArray array{name, "", {}, Values(Eigen::Map<const Eigen::VectorXd>(values.data(), count))};
    if (type == Type::uint8) {
        array.data = std::vector<std::uint8_t>(values.begin(), values.end());
    } else if (!is_real(type) && type != Type::uint32) {
        array.data = std::vector<std::int32_t>(values.begin(), values.end());
    }
    return array;
}

void take_points(const ElementTable& table, FieldFile& field) {
    std::vector<std::string> taken{"x", "y", "z"};
    const auto vectors = [&](const std::vector<std::string>& names) {
        std::vector<Vec3> result(table.columns.empty() ? 0 : table.columns[0].size());
        for (int k = 0; k < 3; ++k) {
            const std::vector<double>& column = *table.find(names[static_cast<std::size_t>(k)]);
            for (std::size_t i = 0; i < result.size(); ++i) {
                result[i][k] = column[i];
            }
        }
        return result;
    };
    const auto has = [&](const std::vector<std::string>& names) {
        return std::all_of(names.begin(), names.end(), [&](const auto& name) { return table.find(name) != nullptr; });
    };
    field.points = vectors(taken);
    const std::vector<std::string> normal{"nx", "ny", "nz"}, colour{"red", "green", "blue"};
    if (has(normal)) {
        field.normals = vectors(normal);
        taken.insert(taken.end(), normal.begin(), normal.end());
    }
    if (has(colour) && std::all_of(colour.begin(), colour.end(), [&](const auto& c) { return table.is_byte(c); })) {
        std::vector<std::uint8_t> bytes(3 * field.points.size());
        for (std::size_t k = 0; k < 3; ++k) {
            const std::vector<double>& column = *table.find(colour[k]);
            for (std::size_t i = 0; i < column.size(); ++i) {
                bytes[3 * i + k] = static_cast<std::uint8_t>(column[i]);
            }
        }
        field.point_arrays.push_back({"display_rgb", "", {"R", "G", "B"}, std::move(bytes)});
        field.active_colours = "display_rgb";
        taken.insert(taken.end(), colour.begin(), colour.end());
    }
    for (std::size_t c = 0; c < table.names.size(); ++c) {
        if (std::find(taken.begin(), taken.end(), table.names[c]) == taken.end()) {
            field.point_arrays.push_back(scalar(table.names[c], table.types[c], table.columns[c], nullptr));
        }
    }
}

/// "quality: luminance in W/m^2" says what the property is.
void name_quality(FieldFile& field) {
    const auto quality = std::find_if(field.point_arrays.begin(), field.point_arrays.end(), [](const FieldArray& a) {
        return a.name == "quality" && std::holds_alternative<Values>(a.data);
    });
    if (quality == field.point_arrays.end()) {
        return;
    }
    const auto note =
        std::find_if(field.notes.rbegin(), field.notes.rend(), [](const FieldNote& n) { return n.name == "quality"; });
    if (note != field.notes.rend()) {
        const std::string text = std::get<std::string>(note->value);
        const std::size_t unit = text.rfind(" in ");
        quality->name = text.substr(0, unit);
        quality->unit = unit == std::string::npos ? "" : text.substr(unit + 4);
        field.notes.erase(std::next(note).base());
    }
    field.quality = quality->name;
}

void take_cells(const ElementTables& tables, const std::string& name, FieldFile& field) {
    Triangles triangles(field, name);
    for (std::size_t cell = 0; cell < tables.faces.corners.size(); ++cell) {
        triangles.add_polygon(tables.faces.corners[cell], cell);
    }
    const std::vector<std::size_t> rows = triangles.cells();
    for (std::size_t cell = 0; cell < tables.strips.corners.size(); ++cell) {
        std::vector<std::int64_t> strip; // several in sequence, each terminated by -1
        for (const std::int64_t corner : tables.strips.corners[cell]) {
            if (corner == -1) {
                triangles.add_strip(strip, cell);
                strip.clear();
            } else {
                strip.push_back(corner);
            }
        }
        triangles.add_strip(strip, cell);
    }
    if (tables.strips.corners.empty()) { // otherwise some cells would have no value
        for (std::size_t c = 0; c < tables.faces.names.size(); ++c) {
            field.cell_arrays.push_back(
                scalar(tables.faces.names[c], tables.faces.types[c], tables.faces.columns[c], &rows));
        }
    }
}

} // namespace

FieldFile read_ply(const std::filesystem::path& file) {
    const std::string name = file.string(), content = read_file(file);
    TextScanner scanner(content, name, {});
    const Header header = parse_header(content, scanner, false);
    ElementTables tables;
    if (header.format == Format::text) {
        tables = read_tables(TextValues(scanner, Layout::free), header);
    } else {
        tables = read_tables(ByteValues(content, name, header), header);
    }
    FieldFile field;
    field.notes = notes_of(std::string_view(content).substr(0, content.find("end_header")));
    take_points(tables.points, field);
    check_coordinates(field, name);
    name_quality(field);
    take_cells(tables, name, field);
    return field;
}

} // namespace difusa
