// Line charts as SVG.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace difusa {

/// Colours that differ.
inline constexpr std::size_t chart_colours = 7;

struct ChartSeries {
    std::string name; ///< in the legend; empty: omitted
    std::vector<double> x, y;
    double width = 2.0;   ///< of the line, in pixels; 0: none
    bool markers = false; ///< a dot at each point
    int colour = 0;       ///< index into a colour-blind-safe palette; -1: black
    bool dashed = false;
};

struct Chart {
    std::string title, x_title, y_title;
    bool x_log = false, y_log = false; ///< if set, only positive values are drawn
    std::vector<ChartSeries> series;
    int width = 720, height = 480; ///< pixels

    /// Adds a point to the last series if that has this name; else begins one, with markers, in the next colour;
    /// in black once the palette is used up.
    void add(const std::string& name, double x, double y);
};

/// The chart as an SVG document: axes with ticks at round values (powers of ten, with their halves and doubles, on log
/// axes), a grid, the lines, a legend. Non-finite values interrupt a line. A chart without any value says so.
std::string svg_of(const Chart& chart);

} // namespace difusa
