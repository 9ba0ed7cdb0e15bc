// Pictures in memory.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace difusa {

/// Linear R, G, B, row by row from the top, left to right.
struct Image {
    std::size_t width = 0, height = 0;
    std::vector<std::array<float, 3>> pixels; ///< width times height

    const std::array<float, 3>& at(std::size_t column, std::size_t row) const { return pixels[row * width + column]; }
};

} // namespace difusa
