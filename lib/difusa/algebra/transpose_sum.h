// Products with the transpose of an operator stored by rows.
#pragma once

#include <difusa/core/parallel.h>
#include <difusa/core/types.h>

#include <algorithm>
#include <vector>

namespace difusa {

/// y = Aᵀ x where `scatter(i, sum)` adds row i of A, times row i of x, to `sum` (#columns of A by #columns of x). Rows
/// are assigned to a fixed number of parts whose sums are added in order: bit-identical for any number of threads.
template <class Scatter>
void sum_transposed(std::size_t rows, std::size_t columns, Eigen::Index width, Values& y, const Execution& execution,
                    const Scatter& scatter) {
    constexpr std::size_t parts = 8;
    std::vector<Values> sums(parts);
    parallel_for(parts, 1, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t p = begin; p < end; ++p) {
            sums[p] = Values::Zero(static_cast<Eigen::Index>(columns), width);
            for (std::size_t i = rows * p / parts; i < rows * (p + 1) / parts; ++i) {
                scatter(i, sums[p]);
            }
        }
    });
    y = std::move(sums.front());
    for (std::size_t p = 1; p < parts; ++p) {
        y += sums[p];
    }
}

} // namespace difusa
