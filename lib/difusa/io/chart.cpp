#include <difusa/io/chart.h>

#include <difusa/core/round_values.h>
#include <difusa/core/text.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

namespace difusa {

namespace {

// Okabe and Ito's palette, without its yellow.
constexpr std::array<const char*, chart_colours> palette{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                                         "#e69f00", "#56b4e9", "#7f7f7f"};

std::string fixed(double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.2f", value);
    return text.data();
}

std::string escaped(const std::string& text) {
    std::string result;
    for (const char c : text) {
        result += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : std::string(1, c);
    }
    return result;
}

/// One axis: values to pixels, and ticks.
class Axis {
  public:
    Axis(const Chart& chart, bool vertical, double from, double to)
        : log_(vertical ? chart.y_log : chart.x_log), from_(from), to_(to) {
        for (const ChartSeries& series : chart.series) {
            for (std::size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i) {
                const double other = vertical ? series.x[i] : series.y[i];
                const double value = vertical ? series.y[i] : series.x[i];
                if (usable(value, log_) && usable(other, vertical ? chart.x_log : chart.y_log)) {
                    low_ = std::min(low_, value);
                    high_ = std::max(high_, value);
                }
            }
        }
        if (empty()) {
            return;
        }
        if (log_) {
            low_ *= 0.9;
            high_ *= 1.1;
        } else {
            const double margin = low_ == high_ ? std::max(1.0, std::abs(low_)) : 0.03 * (high_ - low_);
            low_ -= margin;
            high_ += margin;
        }
    }

    static bool usable(double value, bool log) { return std::isfinite(value) && (!log || value > 0.0); }
    bool empty() const { return !(low_ <= high_); }
    bool holds(double value) const { return usable(value, log_); }
    double pixel(double value) const {
        const double share = log_ ? std::log(value / low_) / std::log(high_ / low_) : (value - low_) / (high_ - low_);
        return from_ + share * (to_ - from_);
    }

    std::vector<double> ticks() const {
        std::vector<double> result;
        if (log_) {
            const double decades = std::log10(high_ / low_);
            const std::vector<double> digits = decades > 4.0   ? std::vector<double>{1.0}
                                               : decades > 1.5 ? std::vector<double>{1.0, 3.0}
                                                               : std::vector<double>{1.0, 2.0, 5.0};
            for (double power = power_of_ten_below(std::max(low_, 1e-300)); power <= high_; power *= 10.0) {
                for (const double digit : digits) {
                    if (digit * power >= low_ && digit * power <= high_) {
                        result.push_back(digit * power);
                    }
                }
            }
            return result;
        }
        const double rough = (high_ - low_) / 6.0, power = power_of_ten_below(rough);
        const double step = power * (rough / power < 1.5   ? 1.0
                                     : rough / power < 3.5 ? 2.0
                                     : rough / power < 7.5 ? 5.0
                                                           : 10.0);
        return multiples_in(low_, high_, step);
    }

  private:
    bool log_;
    double from_, to_;
    double low_ = std::numeric_limits<double>::infinity(), high_ = -std::numeric_limits<double>::infinity();
};

std::string text_at(double x, double y, const std::string& anchor, const std::string& text,
                    const std::string& more = "") {
    return "<text x=\"" + fixed(x) + "\" y=\"" + fixed(y) + "\" text-anchor=\"" + anchor + "\"" + more + ">" +
           escaped(text) + "</text>\n";
}

std::string line(double x1, double y1, double x2, double y2, const std::string& style) {
    return "<line x1=\"" + fixed(x1) + "\" y1=\"" + fixed(y1) + "\" x2=\"" + fixed(x2) + "\" y2=\"" + fixed(y2) +
           "\" " + style + "/>\n";
}

std::string colour_of(const ChartSeries& series) {
    return series.colour < 0 ? "#000000" : palette[static_cast<std::size_t>(series.colour) % palette.size()];
}

std::string stroke(const ChartSeries& series) {
    return "stroke=\"" + colour_of(series) + "\" stroke-width=\"" + fixed(series.width) + "\"" +
           (series.dashed ? " stroke-dasharray=\"6 4\"" : "");
}

} // namespace

void Chart::add(const std::string& name, double x, double y) {
    if (series.empty() || series.back().name != name) {
        ChartSeries next;
        next.name = name;
        next.markers = true;
        const bool left = series.size() < palette.size();
        next.colour = left ? static_cast<int>(series.size()) : -1;
        series.push_back(std::move(next));
    }
    series.back().x.push_back(x);
    series.back().y.push_back(y);
}

std::string svg_of(const Chart& chart) {
    std::size_t longest = 0, named = 0;
    for (const ChartSeries& series : chart.series) {
        longest = std::max(longest, series.name.size());
        named += series.name.empty() ? 0 : 1;
    }
    const double legend = named == 0 ? 16.0 : 48.0 + 7.0 * static_cast<double>(longest);
    const int width = std::max(chart.width, static_cast<int>(legend) + 300);
    const double left = 76.0, right = width - legend, top = 40.0, bottom = chart.height - 52.0;
    const Axis x(chart, false, left, right), y(chart, true, bottom, top);
    std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + std::to_string(width) + "\" height=\"" +
                      std::to_string(chart.height) +
                      "\" font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" "
                      "fill=\"#ffffff\"/>\n";
    svg += text_at(0.5 * (left + right), 22.0, "middle", chart.title, " font-size=\"14\"");
    if (x.empty() || y.empty()) {
        return svg + text_at(0.5 * (left + right), 0.5 * (top + bottom), "middle", "no values") + "</svg>\n";
    }
    for (const double tick : x.ticks()) {
        svg += line(x.pixel(tick), top, x.pixel(tick), bottom, "stroke=\"#dddddd\"");
        svg += text_at(x.pixel(tick), bottom + 18.0, "middle", text_of(tick));
    }
    for (const double tick : y.ticks()) {
        svg += line(left, y.pixel(tick), right, y.pixel(tick), "stroke=\"#dddddd\"");
        svg += text_at(left - 8.0, y.pixel(tick) + 4.0, "end", text_of(tick));
    }
    svg += "<rect x=\"" + fixed(left) + "\" y=\"" + fixed(top) + "\" width=\"" + fixed(right - left) + "\" height=\"" +
           fixed(bottom - top) + "\" fill=\"none\" stroke=\"#000000\"/>\n";
    svg += text_at(0.5 * (left + right), bottom + 40.0, "middle", chart.x_title);
    svg += text_at(18.0, 0.5 * (top + bottom), "middle", chart.y_title,
                   " transform=\"rotate(-90 18 " + fixed(0.5 * (top + bottom)) + ")\"");
    double row = top + 8.0;
    for (const ChartSeries& series : chart.series) {
        std::string points;
        const auto finish = [&] {
            if (!points.empty() && series.width > 0.0) {
                svg += "<polyline fill=\"none\" " + stroke(series) + " points=\"" + points + "\"/>\n";
            }
            points.clear();
        };
        for (std::size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i) {
            if (!x.holds(series.x[i]) || !y.holds(series.y[i])) {
                finish();
                continue;
            }
            const std::string place = fixed(x.pixel(series.x[i])) + "," + fixed(y.pixel(series.y[i]));
            points += (points.empty() ? "" : " ") + place;
            if (series.markers) {
                svg += "<circle cx=\"" + fixed(x.pixel(series.x[i])) + "\" cy=\"" + fixed(y.pixel(series.y[i])) +
                       "\" r=\"3.5\" fill=\"" + colour_of(series) + "\"/>\n";
            }
        }
        finish();
        if (!series.name.empty()) {
            svg += line(right + 10.0, row, right + 32.0, row, stroke(series));
            svg += text_at(right + 38.0, row + 4.0, "start", series.name);
            row += 18.0;
        }
    }
    return svg + "</svg>\n";
}

} // namespace difusa
