#include <difusa/output/point_list.h>

#include <difusa/core/error.h>
#include <difusa/import/file_content.h>
#include <difusa/import/text_scanner.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace difusa {

namespace {

/// Throws InternalError for a value that is no result.
void append(std::string& text, double value) {
    DIFUSA_REQUIRE(std::isfinite(value), "after `" + text.substr(text.find_last_of('\n') + 1) + "`");
    std::array<char, 32> digits{};
    const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
    text += text.empty() || text.back() == '\n' ? "" : ",";
    text.append(digits.data(), end);
}

/// A name as a field of the table: quoted if necessary.
std::string quoted(const std::string& name) {
    if (name.find_first_of(",\"\n\r") == std::string::npos) {
        return name;
    }
    std::string text = "\"";
    for (const char c : name) {
        text += c == '"' ? "\"\"" : std::string(1, c);
    }
    return text + "\"";
}

bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\v' || c == '\f';
}

/// A # that starts a comment, not the one in 1.#INF.
bool is_comment(std::string_view line, std::size_t i) {
    return line[i] == '#' && !(i > 0 && line[i - 1] == '.' && i + 1 < line.size() && !is_blank(line[i + 1]));
}

/// The text in quotation marks starting at `i`, which is moved past them.
std::string quotation(std::string_view line, std::size_t& i, const TextScanner& scanner) {
    const std::size_t end = line.find('"', i + 1);
    if (end == std::string_view::npos) {
        scanner.fail("a quotation mark is never closed: correct the line");
    }
    std::string_view inside = line.substr(i + 1, end - i - 1);
    i = end + 1;
    while (!inside.empty() && is_blank(inside.front())) {
        inside.remove_prefix(1);
    }
    while (!inside.empty() && is_blank(inside.back())) {
        inside.remove_suffix(1);
    }
    return std::string(inside);
}

/// The fields of a line, without surrounding quotation marks and blanks; none is empty.
std::vector<std::string> fields_of(std::string_view line, const TextScanner& scanner) {
    std::vector<std::string> fields;
    char separator = ' ';         // the latest: comma or semicolon
    bool separated = true;        // a separator precedes the next field
    bool after_separator = false; // ... which is a comma or semicolon, so that a field must follow
    const auto refuse_empty = [&] {
        scanner.fail("field " + std::to_string(fields.size() + 1) + " is empty: write a number there, or remove the '" +
                     separator + "'");
    };
    for (std::size_t i = 0; i < line.size() && !is_comment(line, i);) {
        if (is_blank(line[i])) {
            separated = true;
            ++i;
            continue;
        }
        if (line[i] == ',' || line[i] == ';') {
            if (separator != ' ' && separator != line[i]) {
                scanner.fail("the line has both commas and semicolons: separate numbers by one of them, and write "
                             "decimals with a point");
            }
            separator = line[i];
            if (after_separator || fields.empty()) {
                refuse_empty();
            }
            separated = after_separator = true;
            ++i;
            continue;
        }
        std::string field;
        if (line[i] == '"' && separated) {
            field = quotation(line, i, scanner);
        } else {
            for (; i < line.size() && !is_blank(line[i]) && line[i] != ',' && line[i] != ';' && !is_comment(line, i);
                 ++i) {
                field += line[i];
            }
            if (!separated) {
                scanner.fail_unexpected(field, {"a comma, a semicolon or a blank"});
            }
        }
        if (field.empty()) {
            refuse_empty();
        }
        fields.push_back(field);
        separated = after_separator = false;
    }
    if (after_separator) {
        refuse_empty();
    }
    return fields;
}

/// Whether the first line is a heading. Throws if it is neither a heading nor numbers.
bool is_heading(const std::vector<std::string>& fields, const TextScanner& scanner) {
    double value = 0.0;
    if (parse_real(fields.front(), value)) {
        return false;
    }
    std::string names;
    for (const std::string& field : fields) {
        names += (names.empty() ? "" : ",") + lower_case(field);
    }
    if (names != "x,y,z" && names != "x,y,z,nx,ny,nz") {
        scanner.fail("expected numbers, or the heading x,y,z or x,y,z,nx,ny,nz in this order, found " + excerpt(names) +
                     ": correct the line, or put a # before it");
    }
    return true;
}

ListedPoint place_of(const std::vector<std::string>& fields, const TextScanner& scanner) {
    std::vector<double> numbers;
    for (const std::string& field : fields) {
        double value = 0.0;
        if (!parse_real(field, value)) {
            scanner.fail_unexpected(field, {"a coordinate"});
        }
        numbers.push_back(value);
    }
    if (numbers.size() != 3 && numbers.size() != 6) {
        scanner.fail("a point has 3 coordinates, or 3 and a normal of 3, not " + std::to_string(numbers.size()) +
                     " numbers: correct the line");
    }
    const bool finite = std::all_of(numbers.begin(), numbers.end(), [](double v) { return v >= -1e75 && v <= 1e75; });
    if (!finite) {
        scanner.fail("a coordinate is not finite, or beyond 1e75: correct the line");
    }
    ListedPoint point;
    point.position = Vec3(numbers[0], numbers[1], numbers[2]);
    if (numbers.size() == 6) {
        const Vec3 normal(numbers[3], numbers[4], numbers[5]);
        if (!(normal.stableNorm() > 0.0)) {
            scanner.fail("the normal has length 0: give it a direction, or omit it");
        }
        point.normal = normal.stableNormalized();
    }
    return point;
}

} // namespace

std::vector<ListedPoint> read_point_list(const std::filesystem::path& file) {
    const std::string content = read_file(file);
    TextScanner scanner(content, file.string(), {.comments = true});
    std::vector<ListedPoint> points;
    for (bool first = true; scanner.to_token(); first = false) {
        const std::vector<std::string> fields = fields_of(scanner.rest_of_line(), scanner);
        if (first && is_heading(fields, scanner)) {
            continue;
        }
        points.push_back(place_of(fields, scanner));
    }
    if (points.empty()) {
        throw InputError(file.string() + ": contains no points; write x,y,z on each line");
    }
    return points;
}

std::string point_table(const BakeResult& result) {
    const PointValues& values = result.listed_values;
    std::string text = "x,y,z,surface_x,surface_y,surface_z,normal_x,normal_y,normal_z,distance,face";
    std::vector<const Values*> columns{&values.B,          &values.H,   &values.H_direct,
                                       &values.H_indirect, &values.rho, &values.E};
    std::vector<std::string> names{"radiosity",           "irradiance",  "irradiance_direct",
                                   "irradiance_indirect", "reflectance", "emission"};
    for (const GroupValues& group : values.groups) {
        columns.insert(columns.end(), {&group.B, &group.H});
        names.insert(names.end(), {"radiosity_of_" + group.name, "irradiance_of_" + group.name});
    }
    for (const std::string& name : names) {
        for (const char* channel : {"_R", "_G", "_B"}) {
            text += "," + quoted(name + channel);
        }
    }
    text += "\n";
    for (std::size_t i = 0; i < result.listed.size(); ++i) {
        const SurfacePoint& found = result.listed[i];
        for (const Vec3& v : {result.options.at[i].position, found.position, found.normal}) {
            for (const double coordinate : v) {
                append(text, coordinate);
            }
        }
        append(text, result.listed_distance[i]);
        append(text, result.scene->mesh.original_face[found.face]);
        for (const Values* column : columns) {
            for (Eigen::Index c = 0; c < 3; ++c) {
                append(text, (*column)(static_cast<Eigen::Index>(i), c));
            }
        }
        text += "\n";
    }
    return text;
}

} // namespace difusa
