#include <difusa/output/point_list.h>

#include <difusa/core/error.h>
#include <difusa/core/text.h>
#include <difusa/import/file_content.h>
#include <difusa/import/text_scanner.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace difusa {

namespace {

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

} // namespace difusa
