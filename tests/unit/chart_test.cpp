#include <difusa/io/chart.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <regex>

namespace difusa::chart_test {
namespace {

using testing::HasSubstr;
using testing::Not;

/// The points of each polyline, in pixels.
std::vector<std::vector<std::pair<double, double>>> lines(const std::string& svg) {
    std::vector<std::vector<std::pair<double, double>>> result;
    const std::regex polyline("<polyline[^>]* points=\"([^\"]*)\""), pair("([-0-9.]+),([-0-9.]+)");
    for (std::sregex_iterator at(svg.begin(), svg.end(), polyline), end; at != end; ++at) {
        const std::string points = (*at)[1];
        result.emplace_back();
        for (std::sregex_iterator p(points.begin(), points.end(), pair); p != end; ++p) {
            result.back().emplace_back(std::stod((*p)[1]), std::stod((*p)[2]));
        }
    }
    return result;
}

TEST(Chart, ValuesAreInProportion) {
    Chart chart;
    chart.series = {{"line", {0.0, 1.0, 3.0}, {10.0, 20.0, 40.0}}};
    const auto drawn = lines(svg_of(chart));
    ASSERT_EQ(drawn.size(), 1U);
    ASSERT_EQ(drawn[0].size(), 3U);
    const auto& [a, b, c] = std::tie(drawn[0][0], drawn[0][1], drawn[0][2]);
    EXPECT_NEAR((b.first - a.first) / (c.first - a.first), 1.0 / 3.0, 1e-3); // coordinates have two decimals
    EXPECT_NEAR((b.second - a.second) / (c.second - a.second), 1.0 / 3.0, 1e-3);
    EXPECT_LT(c.second, a.second) << "y grows upward";
}

TEST(Chart, LogarithmicAxesPutFactorsAtEqualDistances) {
    Chart chart;
    chart.x_log = chart.y_log = true;
    chart.series = {{"line", {1.0, 10.0, 100.0}, {1e-4, 1e-3, 1e-2}}};
    const auto drawn = lines(svg_of(chart));
    ASSERT_EQ(drawn.size(), 1U);
    EXPECT_NEAR(drawn[0][1].first - drawn[0][0].first, drawn[0][2].first - drawn[0][1].first, 0.02);
    EXPECT_NEAR(drawn[0][1].second - drawn[0][0].second, drawn[0][2].second - drawn[0][1].second, 0.02);
    EXPECT_THAT(svg_of(chart), HasSubstr(">0.001<"));
}

TEST(Chart, WhatCannotBeDrawnInterruptsTheLine) {
    Chart chart;
    chart.y_log = true;
    chart.series = {{"line", {1, 2, 3, 4, 5, 6}, {1.0, 2.0, 0.0, std::nan(""), 3.0, 4.0}}};
    const auto drawn = lines(svg_of(chart));
    ASSERT_EQ(drawn.size(), 2U);
    EXPECT_EQ(drawn[0].size(), 2U);
    EXPECT_EQ(drawn[1].size(), 2U);
}

TEST(Chart, TextsAreEscapedAndEmptyChartsSaySo) {
    Chart chart;
    chart.title = "a < b & c > d";
    const std::string svg = svg_of(chart);
    EXPECT_THAT(svg, HasSubstr("a &lt; b &amp; c &gt; d"));
    EXPECT_THAT(svg, HasSubstr("no values"));
    EXPECT_THAT(svg, HasSubstr("</svg>"));
    chart.series = {{"one", {1.0}, {2.0}, 2.0, true}};
    EXPECT_THAT(svg_of(chart), HasSubstr("<circle"));
    EXPECT_THAT(svg_of(chart), Not(HasSubstr("nan")));
}

TEST(Chart, MarkersAndNamesAreThereForEachSeries) {
    Chart chart;
    for (int k = 0; k < 9; ++k) { // more than the palette has colours
        chart.series.push_back({"series " + std::to_string(k), {0.0, 1.0}, {double(k), double(k)}, 1.0, true, k});
    }
    const std::string svg = svg_of(chart);
    EXPECT_EQ(lines(svg).size(), 9U);
    for (int k = 0; k < 9; ++k) {
        EXPECT_THAT(svg, HasSubstr(">series " + std::to_string(k) + "<"));
    }
}

} // namespace
} // namespace difusa::chart_test
