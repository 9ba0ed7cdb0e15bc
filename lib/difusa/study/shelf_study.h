// The infinite shelf of the lectures (L 33-34) as the limit of shelves of finite length.
#pragma once

#include <difusa/study/measure.h>

#include <functional>
#include <string>
#include <vector>

namespace difusa {

/// A shelf of depth and height 1 beside the infinite one.
struct ShelfTrial {
    double length = 0.0;
    double AB = 0.0, AC = 0.0, BA = 0.0; ///< form factors between whole floor A, back B and ceiling C, to 1e-9
    double factors_off = 0.0;            ///< largest deviation from those of the infinite shelf, relative
    double patches_off = 0.0; ///< of the radiosities of three patches from those of the infinite shelf, relative
    Measurement middle;       ///< of a bake, in the middle
    double bound = 0.0;       ///< of what the length makes the middle's radiosity wrong, relative
};

/// Shelves of these lengths, baked with the options.
std::vector<ShelfTrial> shelf_study(const Registry& registry, const std::vector<double>& lengths,
                                    const BakeOptions& options, const MeasureOptions& how, const Execution& execution,
                                    const std::function<void(const ShelfTrial&)>& tell);

/// A row of a Markdown table, and its header; and as CSV.
std::string shelf_header();
std::string shelf_row(const ShelfTrial& trial);
std::string shelf_csv_header();
std::string shelf_csv_row(const ShelfTrial& trial);

} // namespace difusa
