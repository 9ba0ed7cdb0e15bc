#include <difusa/io/point_list.h>

#include <difusa/core/error.h>
#include <difusa/scene/file_content.h>
#include <difusa/scene/text_scanner.h>

#include <algorithm>
#include <array>
#include <charconv>

namespace difusa {

namespace {

using Reach = TextScanner::Reach;

void append(std::string& text, double value) {
    std::array<char, 32> digits{};
    const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
    text += text.empty() || text.back() == '\n' ? "" : ",";
    text.append(digits.data(), end);
}

/// A name as a field of the table: in quotation marks if it has to be.
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

} // namespace

std::vector<ListedPoint> read_point_list(const std::filesystem::path& file) {
    std::string content = read_file(file);
    std::replace_if(
        content.begin(), content.end(), [](char c) { return c == ',' || c == ';'; }, ' ');
    TextScanner scanner(content, file.string(), {.comments = true});
    std::vector<ListedPoint> points;
    std::vector<double> numbers;
    std::string_view token;
    bool first = true;
    while (scanner.next(token, Reach::file)) {
        numbers.clear();
        bool words = false;
        do {
            double value = 0.0;
            if (parse_real(token, value) && !words) {
                numbers.push_back(value);
            } else if (first && numbers.empty()) {
                words = true;
            } else {
                scanner.fail_unexpected(token, {"a coordinate"});
            }
        } while (scanner.next(token, Reach::line));
        first = false;
        if (words) {
            continue;
        }
        if (numbers.size() != 3 && numbers.size() != 6) {
            scanner.fail("a place has 3 coordinates, or 3 and a normal of 3, not " + std::to_string(numbers.size()) +
                         " numbers: correct the line");
        }
        const bool finite =
            std::all_of(numbers.begin(), numbers.end(), [](double v) { return v >= -1e75 && v <= 1e75; });
        if (!finite) {
            scanner.fail("a coordinate is not finite, or beyond 1e75: correct the line");
        }
        ListedPoint point;
        point.position = Vec3(numbers[0], numbers[1], numbers[2]);
        if (numbers.size() == 6) {
            const Vec3 normal(numbers[3], numbers[4], numbers[5]);
            if (!(normal.stableNorm() > 0.0)) {
                scanner.fail("the normal has no length: give it a direction, or leave it out");
            }
            point.normal = normal.stableNormalized();
        }
        points.push_back(point);
    }
    if (points.empty()) {
        throw InputError(file.string() + ": there is no place in it; write x,y,z on each line");
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
        names.insert(names.end(), {"radiosity_" + group.name, "irradiance_" + group.name});
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
