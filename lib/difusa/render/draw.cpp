#include <difusa/render/draw.h>

#include <difusa/core/digits.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <vector>

namespace difusa {

namespace {

constexpr std::size_t glyph_columns = 5, glyph_rows = 7, glyph_step = 6;

struct Glyph {
    char letter;
    std::array<std::uint8_t, glyph_rows> row; ///< from the top; the highest of five bits is the left column
};

// clang-format off
constexpr Glyph glyphs[] = {
    {'a', {0b00000, 0b00000, 0b01110, 0b00001, 0b01111, 0b10001, 0b01111}},
    {'b', {0b10000, 0b10000, 0b10110, 0b11001, 0b10001, 0b10001, 0b11110}},
    {'c', {0b00000, 0b00000, 0b01110, 0b10000, 0b10000, 0b10001, 0b01110}},
    {'d', {0b00001, 0b00001, 0b01101, 0b10011, 0b10001, 0b10001, 0b01111}},
    {'e', {0b00000, 0b00000, 0b01110, 0b10001, 0b11111, 0b10000, 0b01110}},
    {'f', {0b00110, 0b01001, 0b01000, 0b11100, 0b01000, 0b01000, 0b01000}},
    {'g', {0b00000, 0b01111, 0b10001, 0b10001, 0b01111, 0b00001, 0b01110}},
    {'h', {0b10000, 0b10000, 0b10110, 0b11001, 0b10001, 0b10001, 0b10001}},
    {'i', {0b00100, 0b00000, 0b01100, 0b00100, 0b00100, 0b00100, 0b01110}},
    {'j', {0b00010, 0b00000, 0b00110, 0b00010, 0b00010, 0b10010, 0b01100}},
    {'k', {0b10000, 0b10000, 0b10010, 0b10100, 0b11000, 0b10100, 0b10010}},
    {'l', {0b01100, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110}},
    {'m', {0b00000, 0b00000, 0b11010, 0b10101, 0b10101, 0b10001, 0b10001}},
    {'n', {0b00000, 0b00000, 0b10110, 0b11001, 0b10001, 0b10001, 0b10001}},
    {'o', {0b00000, 0b00000, 0b01110, 0b10001, 0b10001, 0b10001, 0b01110}},
    {'p', {0b00000, 0b00000, 0b11110, 0b10001, 0b11110, 0b10000, 0b10000}},
    {'q', {0b00000, 0b00000, 0b01101, 0b10011, 0b01111, 0b00001, 0b00001}},
    {'r', {0b00000, 0b00000, 0b10110, 0b11001, 0b10000, 0b10000, 0b10000}},
    {'s', {0b00000, 0b00000, 0b01111, 0b10000, 0b01110, 0b00001, 0b11110}},
    {'t', {0b01000, 0b01000, 0b11100, 0b01000, 0b01000, 0b01001, 0b00110}},
    {'u', {0b00000, 0b00000, 0b10001, 0b10001, 0b10001, 0b10011, 0b01101}},
    {'v', {0b00000, 0b00000, 0b10001, 0b10001, 0b10001, 0b01010, 0b00100}},
    {'w', {0b00000, 0b00000, 0b10001, 0b10001, 0b10101, 0b10101, 0b01010}},
    {'x', {0b00000, 0b00000, 0b10001, 0b01010, 0b00100, 0b01010, 0b10001}},
    {'y', {0b00000, 0b00000, 0b10001, 0b10001, 0b01111, 0b00001, 0b01110}},
    {'z', {0b00000, 0b00000, 0b11111, 0b00010, 0b00100, 0b01000, 0b11111}},
    {'K', {0b10001, 0b10010, 0b10100, 0b11000, 0b10100, 0b10010, 0b10001}},
    {'W', {0b10001, 0b10001, 0b10001, 0b10101, 0b10101, 0b11011, 0b10001}},
    {'0', {0b01110, 0b10001, 0b10011, 0b10101, 0b11001, 0b10001, 0b01110}},
    {'1', {0b00100, 0b01100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110}},
    {'2', {0b01110, 0b10001, 0b00001, 0b00110, 0b01000, 0b10000, 0b11111}},
    {'3', {0b11110, 0b00001, 0b00001, 0b01110, 0b00001, 0b00001, 0b11110}},
    {'4', {0b00010, 0b00110, 0b01010, 0b10010, 0b11111, 0b00010, 0b00010}},
    {'5', {0b11111, 0b10000, 0b11110, 0b00001, 0b00001, 0b10001, 0b01110}},
    {'6', {0b00110, 0b01000, 0b10000, 0b11110, 0b10001, 0b10001, 0b01110}},
    {'7', {0b11111, 0b00001, 0b00010, 0b00100, 0b00100, 0b01000, 0b01000}},
    {'8', {0b01110, 0b10001, 0b10001, 0b01110, 0b10001, 0b10001, 0b01110}},
    {'9', {0b01110, 0b10001, 0b10001, 0b01111, 0b00001, 0b00010, 0b01100}},
    {'.', {0b00000, 0b00000, 0b00000, 0b00000, 0b00000, 0b01100, 0b01100}},
    {',', {0b00000, 0b00000, 0b00000, 0b00000, 0b01100, 0b00100, 0b01000}},
    {':', {0b00000, 0b01100, 0b01100, 0b00000, 0b01100, 0b01100, 0b00000}},
    {'+', {0b00000, 0b00100, 0b00100, 0b11111, 0b00100, 0b00100, 0b00000}},
    {'-', {0b00000, 0b00000, 0b00000, 0b11111, 0b00000, 0b00000, 0b00000}},
    {'/', {0b00001, 0b00001, 0b00010, 0b00100, 0b01000, 0b10000, 0b10000}},
    {'^', {0b00100, 0b01010, 0b10001, 0b00000, 0b00000, 0b00000, 0b00000}},
    {'(', {0b00010, 0b00100, 0b01000, 0b01000, 0b01000, 0b00100, 0b00010}},
    {')', {0b01000, 0b00100, 0b00010, 0b00010, 0b00010, 0b00100, 0b01000}},
    {'%', {0b11000, 0b11001, 0b00010, 0b00100, 0b01000, 0b10011, 0b00011}},
    {'=', {0b00000, 0b00000, 0b11111, 0b00000, 0b11111, 0b00000, 0b00000}},
    {'_', {0b00000, 0b00000, 0b00000, 0b00000, 0b00000, 0b00000, 0b11111}},
};
// clang-format on

void blend(Image& image, std::ptrdiff_t column, std::ptrdiff_t row, const Rgb& colour, double part) {
    if (column < 0 || row < 0 || column >= static_cast<std::ptrdiff_t>(image.width) ||
        row >= static_cast<std::ptrdiff_t>(image.height)) {
        return;
    }
    std::array<float, 3>& pixel =
        image.pixels[static_cast<std::size_t>(row) * image.width + static_cast<std::size_t>(column)];
    for (std::size_t c = 0; c < 3; ++c) {
        pixel[c] = static_cast<float>((1.0 - part) * static_cast<double>(pixel[c]) +
                                      part * colour[static_cast<Eigen::Index>(c)]);
    }
}

void draw_box(Image& image, std::ptrdiff_t left, std::ptrdiff_t top, std::ptrdiff_t right, std::ptrdiff_t bottom,
              const Rgb& colour, double part) {
    for (std::ptrdiff_t row = top; row < bottom; ++row) {
        for (std::ptrdiff_t column = left; column < right; ++column) {
            blend(image, column, row, colour, part);
        }
    }
}

std::ptrdiff_t text_width(const std::string& text, std::size_t size) {
    return static_cast<std::ptrdiff_t>(glyph_step * size * text.size());
}

} // namespace

void draw_text(Image& image, const std::string& text, std::ptrdiff_t column, std::ptrdiff_t row, std::size_t size,
               const Rgb& colour) {
    const auto square = static_cast<std::ptrdiff_t>(size);
    for (const char c : text) {
        const auto find = [](char letter) {
            return std::find_if(std::begin(glyphs), std::end(glyphs),
                                [letter](const Glyph& known) { return known.letter == letter; });
        };
        const auto* glyph = find(c);
        if (glyph == std::end(glyphs)) {
            glyph = find(static_cast<char>(std::tolower(static_cast<unsigned char>(c))));
        }
        for (std::size_t y = 0; glyph != std::end(glyphs) && y < glyph_rows; ++y) {
            for (std::size_t x = 0; x < glyph_columns; ++x) {
                if ((glyph->row[y] >> (glyph_columns - 1 - x) & 1U) != 0) {
                    const std::ptrdiff_t left = column + static_cast<std::ptrdiff_t>(x) * square;
                    const std::ptrdiff_t top = row + static_cast<std::ptrdiff_t>(y) * square;
                    draw_box(image, left, top, left + square, top + square, colour, 1.0);
                }
            }
        }
        column += static_cast<std::ptrdiff_t>(glyph_step) * square;
    }
}

void draw_disc(Image& image, double column, double row, double radius, const Rgb& colour) {
    constexpr int grid = 4; // points per direction at which a pixel's coverage is sampled
    const auto first = [&](double middle) { return static_cast<std::ptrdiff_t>(std::floor(middle - radius)); };
    const auto last = [&](double middle) { return static_cast<std::ptrdiff_t>(std::floor(middle + radius)); };
    for (std::ptrdiff_t y = first(row); y <= last(row); ++y) {
        for (std::ptrdiff_t x = first(column); x <= last(column); ++x) {
            int inside = 0;
            for (int k = 0; k < grid * grid; ++k) {
                const int right = k % grid, down = k / grid;
                const double dx = static_cast<double>(x) + (right + 0.5) / grid - column;
                const double dy = static_cast<double>(y) + (down + 0.5) / grid - row;
                inside += dx * dx + dy * dy <= radius * radius ? 1 : 0;
            }
            blend(image, x, y, colour, static_cast<double>(inside) / (grid * grid));
        }
    }
}

std::string bar_label(double value) {
    return with_digits(value, 3);
}

namespace {

struct Label {
    std::string text;
    std::ptrdiff_t row; ///< of its middle
};

/// Both ends, and the round values that keep away from them and from each other.
std::vector<Label> labels_of(const ColourScale& scale, std::ptrdiff_t top, std::ptrdiff_t bottom, std::ptrdiff_t line) {
    std::vector<Label> labels{{bar_label(scale.low), bottom}, {bar_label(scale.high), top}};
    std::ptrdiff_t below = bottom;
    for (const double tick : scale.ticks()) {
        const double along = (1.0 - scale.position(tick)) * static_cast<double>(bottom - top);
        const std::ptrdiff_t row = top + static_cast<std::ptrdiff_t>(std::lround(along));
        if (below - row >= 3 * line / 2 && row - top >= 3 * line / 2) {
            labels.push_back({bar_label(tick), row});
            below = row;
        }
    }
    return labels;
}

} // namespace

Image with_colour_bar(const Image& image, const ColourScale& scale, const std::string& title) {
    const Rgb black = Rgb::Zero();
    const std::size_t size = std::max<std::size_t>(1, image.height / 250);
    const auto unit = static_cast<std::ptrdiff_t>(glyph_step * size);
    const auto line = static_cast<std::ptrdiff_t>(glyph_rows * size);
    const auto width = static_cast<std::ptrdiff_t>(image.width), height = static_cast<std::ptrdiff_t>(image.height);
    const std::size_t comma = std::min(title.find(", "), title.size()); // the unit goes below the name
    const std::string name = title.substr(0, comma), in = title.substr(std::min(comma + 2, title.size()));
    const std::ptrdiff_t top = unit + 4 * line, bottom = height - unit - line, bar = 3 * unit;
    const std::vector<Label> labels = bottom - top < 2 ? std::vector<Label>() : labels_of(scale, top, bottom, line);
    std::ptrdiff_t widest = std::max(text_width(name, size), text_width(in, size));
    for (const Label& label : labels) {
        widest = std::max(widest, bar + unit + text_width(label.text, size));
    }
    Image whole{static_cast<std::size_t>(width + widest + 2 * unit), image.height, {}};
    whole.pixels.assign(whole.width * whole.height, {1.0F, 1.0F, 1.0F});
    for (std::size_t row = 0; row < image.height; ++row) {
        const auto from = image.pixels.begin() + static_cast<std::ptrdiff_t>(row * image.width);
        std::copy(from, from + width, whole.pixels.begin() + static_cast<std::ptrdiff_t>(row * whole.width));
    }
    const std::ptrdiff_t left = width + unit;
    draw_text(whole, name, left, unit, size, black);
    draw_text(whole, in, left, unit + 3 * line / 2, size, black);
    for (std::ptrdiff_t row = top; row < bottom && !labels.empty(); ++row) {
        const double t = 1.0 - (static_cast<double>(row - top) + 0.5) / static_cast<double>(bottom - top);
        draw_box(whole, left, row, left + bar, row + 1, colour_map(t), 1.0);
    }
    for (const Label& label : labels) {
        draw_box(whole, left + bar, label.row, left + bar + unit / 2, label.row + 1, black, 1.0);
        draw_text(whole, label.text, left + bar + unit, label.row - line / 2, size, black);
    }
    return whole;
}

} // namespace difusa
