#include <difusa/output/series_files.h>

#include <difusa/core/text.h>
#include <difusa/io/field_writers.h>
#include <difusa/output/bake_files.h>
#include <difusa/output/point_list.h>

#include <array>
#include <cstdio>
#include <sstream>
#include <utility>

namespace difusa {

std::filesystem::path series_member(const std::filesystem::path& series, std::size_t number) {
    std::array<char, 32> digits{};
    std::snprintf(digits.data(), digits.size(), "_%04zu.vtp", number);
    std::filesystem::path member = series;
    member.replace_filename(series.stem().string() + digits.data());
    return member;
}

SeriesWriter::SeriesWriter(std::filesystem::path series, std::filesystem::path table)
    : series_(std::move(series)), table_(std::move(table)) {}

void SeriesWriter::add(const SunStep& step, const BakeResult& result, const Execution& execution) {
    execution.phase("write");
    const std::filesystem::path member = series_member(series_, fields_.size());
    fields_.push_back(std::make_unique<WholeFile>(member));
    FieldFile field = field_of(result);
    field.notes.push_back({"hours", std::vector<double>{step.hours}});
    field.notes.push_back({"sun_azimuth", std::vector<double>{step.position.azimuth}});
    field.notes.push_back({"sun_elevation", std::vector<double>{step.position.elevation}});
    write_finite_field(field, member, *fields_.back(), execution);
    fields_.back()->finish();
    members_ += "    <DataSet timestep=\"" + exact_text(step.hours) + "\" part=\"0\" file=\"" +
                xml_attribute(member.filename().string()) + "\"/>\n";
    if (table_.empty()) {
        return;
    }
    std::istringstream lines(point_table(result));
    std::string line;
    std::getline(lines, line);
    if (rows_.empty()) {
        rows_ = "hours,sun_azimuth,sun_elevation," + line + "\n";
    }
    const std::string when = exact_text(step.hours) + "," + exact_text(step.position.azimuth) + "," +
                             exact_text(step.position.elevation) + ",";
    while (std::getline(lines, line)) {
        rows_ += when + line + "\n";
    }
}

void SeriesWriter::commit() {
    const auto write = [&](const std::filesystem::path& file, const std::string& content) {
        fields_.push_back(std::make_unique<WholeFile>(file));
        fields_.back()->write(content);
        fields_.back()->finish();
    };
    if (!table_.empty()) {
        write(table_, rows_);
    }
    write(series_,
          "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
          "  <Collection>\n" +
              members_ + "  </Collection>\n</VTKFile>\n");
    for (const std::unique_ptr<WholeFile>& file : fields_) {
        file->commit();
    }
}

} // namespace difusa
