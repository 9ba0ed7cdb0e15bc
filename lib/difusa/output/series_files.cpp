#include <difusa/output/series_files.h>

#include <difusa/bake/steps.h>
#include <difusa/core/text.h>
#include <difusa/io/field_writers.h>
#include <difusa/output/bake_files.h>
#include <difusa/output/point_table.h>

#include <array>
#include <cmath>
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
    add(
        SeriesStep{
            step.hours,
            {{"hours", step.hours}, {"sun_azimuth", step.position.azimuth}, {"sun_elevation", step.position.elevation}},
            {}},
        result, execution);
}

void SeriesWriter::add_iterates(const BakeResult& result, const Execution& execution) {
    if (result.solution.iterates.empty()) {
        return;
    }
    execution.phase("write convergence");
    const Unreported unreported(execution);
    BakeResult shown = result;
    shown.options.final_gather = 0;
    shown.options.at.clear();
    shown.options.grids.clear();
    shown.listed.clear();
    shown.sensors.clear();
    shown.error.reset(); // and what else is known of the solution alone
    shown.errors.reset();
    shown.goals.clear();
    shown.goal_estimates.clear();
    const double exposure = display_exposure(result);
    const auto points = static_cast<double>(result.system->transport().points());
    for (const KeptIterate& iterate : result.solution.iterates) {
        const double iterations = static_cast<double>(iterate.relaxations) / points;
        shown.solution.field = result.solution.field_of(iterate);
        shown.solution.solve.iterations = static_cast<int>(std::ceil(iterations));
        shown.solution.solve.residual = iterate.residual;
        evaluate_anew(shown, unreported);
        add(SeriesStep{iterations,
                       {{"relaxations", static_cast<double>(iterate.relaxations)},
                        {"entries_touched", static_cast<double>(iterate.entries)}},
                       exposure},
            shown, unreported);
    }
}

void SeriesWriter::add(const SeriesStep& step, const BakeResult& result, const Execution& execution) {
    execution.phase("write");
    const std::filesystem::path member = series_member(series_, fields_.size());
    fields_.push_back(std::make_unique<WholeFile>(member));
    FieldFile field = field_of(result, step.exposure);
    std::string names, when;
    for (const auto& [name, value] : step.values) {
        field.notes.push_back({name, std::vector<double>{value}});
        names += name + ",";
        when += exact_text(value) + ",";
    }
    write_finite_field(field, member, *fields_.back(), execution);
    fields_.back()->finish();
    members_ += "    <DataSet timestep=\"" + exact_text(step.time) + "\" part=\"0\" file=\"" +
                xml_attribute(member.filename().string()) + "\"/>\n";
    if (table_.empty()) {
        return;
    }
    std::istringstream lines(point_table(result));
    std::string line;
    std::getline(lines, line);
    if (rows_.empty()) {
        rows_ = names + line + "\n";
    }
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
