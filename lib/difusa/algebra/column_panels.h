// The columns of a product, in panels whose number of columns is known when the program is compiled.
#pragma once

#include <Eigen/Core>

#include <type_traits>

namespace difusa {

/// Divides columns 0 ... width - 1 into panels of these sizes, as many as fit of each in turn, and calls
/// `act(size, first column)` for each panel; the size is a constant, so that the sums of a panel may stay in registers.
/// If the last size is 1, no column is left over.
template <int... sizes, class Act> void for_panels(Eigen::Index width, const Act& act) {
    Eigen::Index first = 0;
    const auto take = [&](auto size) {
        for (; first + size <= width; first += size) {
            act(size, first);
        }
    };
    (take(std::integral_constant<int, sizes>()), ...);
}

} // namespace difusa
