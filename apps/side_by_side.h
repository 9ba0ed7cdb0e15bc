// measure_accuracy --side-by-side: the classical method beside the meshless one, as tables and charts.
#pragma once

#include <difusa/study/measure.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace difusa {

struct SideBySide {
    BakeOptions common;
    std::vector<std::size_t> sites;         ///< of each method, about
    std::vector<std::string> cases, scenes; ///< with known solutions; files, judged by finer bakes
    MeasureOptions how;
};

/// Writes side_by_side.md, side_by_side.csv and a chart of each scene into the folder, and prints the table unless
/// `quiet`.
void write_side_by_side(const SideBySide& plan, const std::filesystem::path& folder, bool quiet,
                        const Registry& registry, const Execution& execution);

} // namespace difusa
