#include <difusa/output/daylight_files.h>

#include <difusa/core/error.h>
#include <difusa/core/photometry.h>
#include <difusa/core/text.h>
#include <difusa/import/file_content.h>
#include <difusa/import/text_scanner.h>
#include <difusa/io/npz_file.h>
#include <difusa/io/whole_file.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string_view>

namespace difusa {

namespace {

std::string three_numbers(const Vec3& v) {
    return exact_text(v.x()) + " " + exact_text(v.y()) + " " + exact_text(v.z());
}

/// One channel of the coefficients, #points by #parts, row by row.
std::vector<double> coefficients_of_channel(const DaylightCoefficients& coefficients, int channel) {
    const int channels = coefficients.channels;
    std::vector<double> values;
    values.reserve(static_cast<std::size_t>(coefficients.value.size() / channels));
    for (Eigen::Index i = 0; i < coefficients.value.rows(); ++i) {
        for (Eigen::Index k = channels == 1 ? 0 : channel; k < coefficients.value.cols(); k += channels) {
            values.push_back(coefficients.value(i, k));
        }
    }
    return values;
}

/// Each value with eight digits, three to a part, a row to a line.
void write_radiance(const DaylightMatrix& matrix, WholeFile& file) {
    const DaylightCoefficients& coefficients = matrix.coefficients;
    const int channels = coefficients.channels;
    const Eigen::Index parts = coefficients.value.cols() / channels;
    file.write(
        "#?RADIANCE\nSOFTWARE= difusa, daylight coefficients: irradiance of the points (rows) for a radiance of 1 "
        "of the parts of the sky (columns)\nSKY_DIVISION= MF:" +
        std::to_string(matrix.sky.factor()) + "\nSKY_UP= " + three_numbers(matrix.sky.up()) +
        "\nSKY_NORTH= " + three_numbers(matrix.sky.north()) + "\nNROWS=" + std::to_string(coefficients.value.rows()) +
        "\nNCOLS=" + std::to_string(parts) + "\nNCOMP=3\nFORMAT=ascii\n\n");
    std::string line;
    char text[96];
    for (Eigen::Index i = 0; i < coefficients.value.rows(); ++i) {
        line.clear();
        for (Eigen::Index p = 0; p < parts; ++p) {
            const auto at = [&](int c) { return coefficients.value(i, p * channels + (channels == 1 ? 0 : c)); };
            std::snprintf(text, sizeof text, "%.8g %.8g %.8g%c", at(0), at(1), at(2), p + 1 == parts ? '\n' : '\t');
            line += text;
        }
        file.write(line);
    }
}

void write_arrays(const DaylightMatrix& matrix, bool photometric, WholeFile& file) {
    NpzWriter npz(file);
    const auto parts = static_cast<std::size_t>(matrix.sky.count());
    const std::vector<double> red = coefficients_of_channel(matrix.coefficients, 0),
                              green = coefficients_of_channel(matrix.coefficients, 1),
                              blue = coefficients_of_channel(matrix.coefficients, 2);
    npz.array("red", red, parts);
    npz.array("green", green, parts);
    npz.array("blue", blue, parts);
    if (photometric) {
        std::vector<double> lux(red.size());
        for (std::size_t k = 0; k < lux.size(); ++k) {
            lux[k] = lumens_per_watt * luminance({red[k], green[k], blue[k]});
        }
        npz.array("illuminance", lux, parts);
    }
    std::vector<double> position, normal, direction, solid_angle;
    const auto append = [](std::vector<double>& all, const Vec3& v) { all.insert(all.end(), v.data(), v.data() + 3); };
    for (const SurfacePoint& point : matrix.points) {
        append(position, point.position);
        append(normal, point.normal);
    }
    for (Index part = 0; part < matrix.sky.count(); ++part) {
        append(direction, matrix.sky.centre(part));
        solid_angle.push_back(matrix.sky.cell(part).solid_angle());
    }
    npz.array("position", position, 3);
    npz.array("normal", normal, 3);
    npz.array("part_direction", direction, 3);
    npz.array("part_solid_angle", solid_angle);
    npz.finish();
}

/// What the header of a matrix says.
struct RadianceHeader {
    std::int64_t rows = 0, columns = 0, components = 3;
    std::string format;
    std::string up = "0 0 1", north = "0 1 0";
};

std::optional<std::string_view> header_value(std::string_view line, std::string_view name) {
    if (!line.starts_with(name)) {
        return std::nullopt;
    }
    line.remove_prefix(name.size());
    while (!line.empty() && is_blank(line.front())) {
        line.remove_prefix(1);
    }
    while (!line.empty() && (is_blank(line.back()) || line.back() == '\r')) {
        line.remove_suffix(1);
    }
    return line;
}

[[noreturn]] void refuse_matrix(const std::filesystem::path& file, const std::string& problem) {
    throw InputError(file.string() + ": " + problem);
}

/// Reads the lines up to the empty one, and takes them off the content.
RadianceHeader matrix_header(std::string_view& content, const std::filesystem::path& file) {
    if (!content.starts_with("#?")) {
        refuse_matrix(file, "is no matrix of daylight coefficients: the first line must begin with #?RADIANCE");
    }
    RadianceHeader header;
    for (;;) {
        const std::size_t end = content.find('\n');
        if (end == std::string_view::npos) {
            refuse_matrix(file, "ends within its header: the empty line after it is missing");
        }
        const std::string_view line = content.substr(0, end);
        content.remove_prefix(end + 1);
        if (line.empty() || line == "\r") {
            return header;
        }
        const auto number = [&](std::string_view name, std::int64_t& target) {
            const auto value = header_value(line, name);
            if (value && (!parse_integer(*value, target) || target < 1)) {
                refuse_matrix(file, std::string(line) + ": must be a whole number of at least 1");
            }
        };
        number("NROWS=", header.rows);
        number("NCOLS=", header.columns);
        number("NCOMP=", header.components);
        header.format = header_value(line, "FORMAT=").value_or(header.format);
        header.up = header_value(line, "SKY_UP=").value_or(header.up);
        header.north = header_value(line, "SKY_NORTH=").value_or(header.north);
    }
}

Vec3 header_direction(const std::string& text, const std::filesystem::path& file) {
    TextScanner scanner(text, file.string(), {});
    Vec3 v;
    for (int k = 0; k < 3; ++k) {
        v[k] = scanner.real({"a coordinate of a direction"}, TextScanner::Reach::file);
    }
    if (!v.allFinite() || !(v.norm() > 0.0)) {
        refuse_matrix(file, "SKY_UP and SKY_NORTH must be directions");
    }
    return v.normalized();
}

int division_factor(std::int64_t columns, const std::filesystem::path& file) {
    for (int factor = 1; factor <= SkyDivision::most; ++factor) {
        if (columns == 144 * factor * factor + 2) {
            return factor;
        }
    }
    refuse_matrix(file, "has " + std::to_string(columns) +
                            " columns: a Reinhart sky has 146, 578, 1298, 2306, ..., of which "
                            "the first is the ground");
}

} // namespace

void check_daylight_file(const std::filesystem::path& file) {
    const std::string extension = file.extension().string();
    if (extension != ".mtx" && extension != ".npz") {
        throw UsageError("cannot write daylight coefficients to `" + file.string() +
                         "`: the name must end in .mtx (Radiance) or .npz (NumPy)");
    }
}

void write_daylight(const DaylightMatrix& matrix, bool photometric, const std::filesystem::path& file) {
    check_daylight_file(file);
    WholeFile out(file);
    if (file.extension() == ".npz") {
        write_arrays(matrix, photometric, out);
    } else {
        write_radiance(matrix, out);
    }
    out.commit();
}

DaylightTable read_daylight(const std::filesystem::path& file) {
    const std::string text = read_file(file);
    std::string_view content = text;
    const RadianceHeader header = matrix_header(content, file);
    if (header.format != "ascii" || header.components != 3 || header.rows == 0 || header.columns == 0) {
        refuse_matrix(file,
                      "must have FORMAT=ascii, NCOMP=3, NROWS and NCOLS in its header (rmtxop -fa converts others)");
    }
    const int factor = division_factor(header.columns, file);
    if (static_cast<std::size_t>(header.rows) > content.size() / static_cast<std::size_t>(6 * header.columns - 1)) {
        refuse_matrix(file, "is too short for " + std::to_string(header.rows) + " rows");
    }
    DaylightTable table{SkyDivision(factor, header_direction(header.up, file), header_direction(header.north, file)),
                        {}};
    table.coefficients.value.resize(header.rows, 3 * header.columns);
    const auto lines = std::count(text.data(), content.data(), '\n');
    TextScanner scanner(content, file.string(), {}, static_cast<std::uint32_t>(lines) + 1);
    for (Eigen::Index i = 0; i < table.coefficients.value.size(); ++i) {
        const double value = scanner.real({"a coefficient"}, TextScanner::Reach::file);
        if (!std::isfinite(value) || value < 0.0) {
            scanner.fail("a coefficient must be finite, and not negative");
        }
        table.coefficients.value.data()[i] = value;
    }
    if (scanner.to_token()) {
        scanner.fail("there are more numbers than " + std::to_string(header.rows) + " rows have");
    }
    return table;
}

std::string daylight_table(const Values& irradiance, const std::vector<SurfacePoint>& points) {
    DIFUSA_REQUIRE(points.empty() || static_cast<Eigen::Index>(points.size()) == irradiance.rows());
    const Values lux = illuminance_of(irradiance);
    std::string table = "point,x,y,z,nx,ny,nz,irradiance_r,irradiance_g,irradiance_b,illuminance\n";
    for (Eigen::Index i = 0; i < irradiance.rows(); ++i) {
        table += std::to_string(i);
        for (int k = 0; k < 6; ++k) {
            table += ",";
            if (!points.empty()) {
                const SurfacePoint& point = points[static_cast<std::size_t>(i)];
                table += exact_text(k < 3 ? point.position[k] : point.normal[k - 3]);
            }
        }
        for (Eigen::Index c = 0; c < 3; ++c) {
            table += "," + exact_text(irradiance(i, c));
        }
        table += "," + exact_text(lux(i, 0)) + "\n";
    }
    return table;
}

} // namespace difusa
