// The columns of a product, in panels whose number of columns is known when the program is compiled.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cstddef>
#include <type_traits>

namespace difusa {

/// Divides columns 0 ... width - 1 into panels of these sizes, which descend to 1, as many as fit of each in turn, and
/// calls `act(size, first column)` for each panel; the size is a constant, so that the sums of a panel may stay in
/// registers. A panel of a few columns takes as long to read its entries as a wide one: so a rest that would take
/// several panels, and fills at least half of one, has that one, together with columns that an earlier panel had.
template <int... sizes, class Act> void for_panels(Eigen::Index width, const Act& act) {
    constexpr std::array<int, sizeof...(sizes) + 1> each{sizes..., 0};
    static_assert(each[sizeof...(sizes) - 1] == 1);
    Eigen::Index first = 0;
    std::size_t next = 1; // of the sizes
    const auto take = [&](auto size) {
        for (; first + size <= width; first += size) {
            act(size, first);
        }
        if (const Eigen::Index rest = width - first; rest > each[next] && 2 * rest >= size && size <= width) {
            act(size, width - size);
            first = width;
        }
        ++next;
    };
    (take(std::integral_constant<int, sizes>()), ...);
}

} // namespace difusa
