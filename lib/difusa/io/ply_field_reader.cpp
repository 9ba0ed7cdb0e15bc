// Unlike the mesh reader `ply` this keeps what stands at the points: normals, colours, quality and all other numbers.
#include <difusa/io/field_readers.h>

#include <difusa/core/error.h>
#include <difusa/import/byte_scanner.h>
#include <difusa/import/file_content.h>
#include <difusa/import/ply_header.h>

#include <algorithm>
#include <bit>
#include <cctype>

namespace difusa {

namespace {

using namespace ply;
using Reach = TextScanner::Reach;

// ---- values, from text and from bytes -------------------------------------------------------------------------

class TextSource {
  public:
    explicit TextSource(TextScanner& scanner) : scanner_(scanner) {}

    static double least_bytes(Type) { return 2.0; } // a digit and a blank
    double available() const { return static_cast<double>(scanner_.remaining()) + 1.0; }
    double real(Type type, const Expected& expected) {
        if (is_real(type)) {
            return scanner_.real(expected, Reach::file);
        }
        const std::int64_t value = scanner_.integer(expected, Reach::file);
        const bool has_sign = type == Type::int8 || type == Type::int16 || type == Type::int32;
        const std::int64_t values = std::int64_t{1} << (8 * size_of(type)), least = has_sign ? -values / 2 : 0;
        if (value < least || value >= least + values) {
            scanner_.fail(std::to_string(value) + " is out of the range of " + expected.text() +
                          ", whose type the header says: correct the header, or write the file again");
        }
        return static_cast<double>(value);
    }
    std::int64_t integer(Type, const Expected& expected) { return scanner_.integer(expected, Reach::file); }
    [[noreturn]] void fail(const std::string& problem) const { scanner_.fail(problem); }
    void finish() {
        std::string_view token;
        if (scanner_.next(token, Reach::file)) {
            scanner_.fail("the file goes on with " + excerpt(token) +
                          " after all its header announces: the file is damaged; write it again");
        }
    }

  private:
    TextScanner& scanner_;
};

class ByteSource {
  public:
    explicit ByteSource(ByteScanner scanner) : scanner_(std::move(scanner)) {}

    static double least_bytes(Type type) { return static_cast<double>(size_of(type)); }
    double available() const { return static_cast<double>(scanner_.remaining()); }
    double real(Type type, const Expected& expected) {
        return type == Type::float32   ? static_cast<double>(scanner_.take<float>(expected))
               : type == Type::float64 ? scanner_.take<double>(expected)
                                       : static_cast<double>(integer(type, expected));
    }
    std::int64_t integer(Type type, const Expected& expected) {
        switch (type) {
        case Type::int8:
            return scanner_.take<std::int8_t>(expected);
        case Type::uint8:
            return scanner_.take<std::uint8_t>(expected);
        case Type::int16:
            return scanner_.take<std::int16_t>(expected);
        case Type::uint16:
            return scanner_.take<std::uint16_t>(expected);
        case Type::int32:
            return scanner_.take<std::int32_t>(expected);
        default:
            return scanner_.take<std::uint32_t>(expected); // no list has a length, no corner a number of a real type
        }
    }
    [[noreturn]] void fail(const std::string& problem) const { scanner_.fail(problem); }
    void finish() {
        if (scanner_.remaining() > 0) {
            scanner_.fail("the file goes on after all its header announces: the file is damaged; write it again");
        }
    }

  private:
    ByteScanner scanner_;
};

// ---- elements -------------------------------------------------------------------------------------------------

/// The scalar properties of an element, and the lists of corners among them.
struct Table {
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

template <class Source> Table read_table(Source& source, const Element& element) {
    Table table;
    for (const Property& property : element.properties) {
        if (!property.count_type) {
            table.names.push_back(property.name);
            table.types.push_back(property.type);
        }
    }
    table.columns.resize(table.names.size());
    const bool cells = element.kind == Element::Kind::faces || element.kind == Element::Kind::strips;
    if (element.properties.empty()) {
        return table;
    }
    for (std::size_t row = 0; row < element.count; ++row) {
        std::size_t column = 0;
        for (const Property& property : element.properties) {
            const Expected expected{property.name.c_str(), row + 1, element.count};
            if (!property.count_type) {
                table.columns[column++].push_back(source.real(property.type, expected));
                continue;
            }
            const std::int64_t length = source.integer(*property.count_type, expected);
            if (length < 0 || static_cast<double>(length) * Source::least_bytes(property.type) > source.available()) {
                source.fail("a list '" + property.name + "' announces " + std::to_string(length) +
                            " entries, which is impossible: the file is damaged; write it again");
            }
            const bool wanted = cells && property.role == corners;
            std::vector<std::int64_t> list;
            for (std::int64_t k = 0; k < length; ++k) {
                if (wanted) {
                    list.push_back(source.integer(property.type, expected));
                } else {
                    source.real(property.type, expected);
                }
            }
            if (wanted) {
                table.corners.push_back(std::move(list));
            }
        }
    }
    return table;
}

struct Tables {
    Table points, faces, strips;
};

template <class Source> Tables read_tables(Source source, const Header& header) {
    double least = 0.0;
    for (const Element& element : header.elements) {
        for (const Property& property : element.properties) {
            least +=
                static_cast<double>(element.count) * Source::least_bytes(property.count_type.value_or(property.type));
        }
    }
    if (least > source.available()) {
        source.fail("the header announces more data than follow: the file was cut short or its header is wrong; write "
                    "it again");
    }
    Tables tables;
    for (const Element& element : header.elements) {
        Table table = read_table(source, element);
        switch (element.kind) {
        case Element::Kind::points:
            tables.points = std::move(table);
            break;
        case Element::Kind::faces:
            tables.faces = std::move(table);
            break;
        case Element::Kind::strips:
            tables.strips = std::move(table);
            break;
        case Element::Kind::other:
            break;
        }
    }
    source.finish();
    return tables;
}

// ---- the field ------------------------------------------------------------------------------------------------

/// The comments of the header: "name: text", long ones going on in the next (ply_writer.cpp). Others have no name.
std::vector<FieldNote> notes_of(std::string_view header) {
    constexpr std::string_view mark = "comment ";
    constexpr std::size_t longest = 200;
    std::vector<FieldNote> notes;
    std::size_t last = 0; ///< length of the comment in the line before
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

void take_points(const Table& table, FieldFile& field) {
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

void take_cells(const Tables& tables, const std::string& name, FieldFile& field) {
    Triangles triangles(field, name);
    for (std::size_t cell = 0; cell < tables.faces.corners.size(); ++cell) {
        triangles.add_polygon(tables.faces.corners[cell], cell);
    }
    const std::vector<std::size_t> rows = triangles.cells();
    for (std::size_t cell = 0; cell < tables.strips.corners.size(); ++cell) {
        std::vector<std::int64_t> strip; // several one after another, each ended by -1
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
    if (tables.strips.corners.empty()) { // else some cells would have no value
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
    Tables tables;
    if (header.format == Format::text) {
        tables = read_tables(TextSource(scanner), header);
    } else {
        const std::endian order = header.format == Format::big_endian ? std::endian::big : std::endian::little;
        tables = read_tables(ByteSource(ByteScanner(content, name, order, header.bytes)), header);
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
