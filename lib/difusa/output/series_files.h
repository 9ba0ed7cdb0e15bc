// The files of a series: one field for each time, a list of them that ParaView plays, and a table. The times are those
// of a day, or the iterations of a solver.
#pragma once

#include <difusa/bake/result.h>
#include <difusa/bake/sun_path.h>
#include <difusa/core/progress.h>
#include <difusa/io/whole_file.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace difusa {

/// An upper bound on the iterates that a solver shows.
inline constexpr std::size_t most_iterates = 128;

/// The name of the field of a time: "day_0007.vtp" for 7 and "day.pvd".
std::filesystem::path series_member(const std::filesystem::path& series, std::size_t number);

/// One field of a series.
struct SeriesStep {
    double time = 0.0;
    std::vector<std::pair<std::string, double>> values; ///< notes of the field, and first columns of the table
    std::optional<double> exposure;                     ///< of display_rgb; absent: that of the field
};

/// Writes fields under temporary names as they come; none appears under its own before `commit`.
class SeriesWriter {
  public:
    /// `series`: the .pvd; `table`: the light at the places of --at and --grid at all times, empty: none.
    SeriesWriter(std::filesystem::path series, std::filesystem::path table);

    /// Throws what `write_bake` throws.
    void add(const SeriesStep& step, const BakeResult& result, const Execution& execution);
    void add(const SunStep& step, const BakeResult& result, const Execution& execution);

    /// The fields of all iterates that the result has kept, evaluated from the basis; the time is the number of
    /// iterations, which is broken where only some unknowns were relaxed. The exposure is that of the solution.
    void add_iterates(const BakeResult& result, const Execution& execution);

    /// Number of fields.
    std::size_t size() const { return fields_.size(); }

    /// Writes series and table, and commits all files.
    void commit();

  private:
    std::filesystem::path series_, table_;
    std::vector<std::unique_ptr<WholeFile>> fields_;
    std::string members_, rows_;
};

} // namespace difusa
