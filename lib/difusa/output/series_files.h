// The files of a series of lightings: one field for each time, a list of them that ParaView plays, and a table.
#pragma once

#include <difusa/bake/result.h>
#include <difusa/bake/sun_path.h>
#include <difusa/core/progress.h>
#include <difusa/io/whole_file.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace difusa {

/// The name of the field of a time: "day_0007.vtp" for 7 and "day.pvd".
std::filesystem::path series_member(const std::filesystem::path& series, std::size_t number);

/// Writes fields under temporary names as they come; none appears under its own before `commit`.
class SeriesWriter {
  public:
    /// `series`: the .pvd; `table`: the light at the places of --at and --grid at all times, empty: none.
    SeriesWriter(std::filesystem::path series, std::filesystem::path table);

    /// Throws what `write_bake` throws.
    void add(const SunStep& step, const BakeResult& result, const Execution& execution);

    /// Writes series and table, and commits all files.
    void commit();

  private:
    std::filesystem::path series_, table_;
    std::vector<std::unique_ptr<WholeFile>> fields_;
    std::string members_, rows_;
};

} // namespace difusa
