// Long vectors block by block, in parallel: sums are those of the blocks in order, so that results do not depend on the
// number of threads.
#pragma once

#include <difusa/core/parallel.h>
#include <difusa/core/types.h>

#include <algorithm>
#include <span>

namespace difusa {

constexpr Eigen::Index block_length = 16384;

/// The blocks that make up a vector depend on its size alone.
constexpr Eigen::Index block_count(Eigen::Index size) {
    return (size + block_length - 1) / block_length;
}

/// Calls `body(first, count, block)` for each block, with the range of indices that it covers.
template <class Body> void for_blocks(Eigen::Index size, const Execution& execution, const Body& body) {
    parallel_for(static_cast<std::size_t>(block_count(size)), 1, execution.silent(),
                 [&](std::size_t begin, std::size_t end, unsigned) {
                     for (std::size_t block = begin; block < end; ++block) {
                         const Eigen::Index first = static_cast<Eigen::Index>(block) * block_length;
                         body(first, std::min(block_length, size - first), static_cast<Eigen::Index>(block));
                     }
                 });
}

/// ‖x‖₂, also where squares would under- or overflow.
double norm(const Eigen::VectorXd& x, const Execution& execution);

/// w -= V Vᵀ w for orthonormal vectors V. Projects twice, which is enough for w to be orthogonal to them up to rounding
/// (Giraud, Langou and Rozloznik 2005). Returns Vᵀ w, #V.
Eigen::VectorXd orthogonalise(std::span<const Eigen::VectorXd> V, Eigen::VectorXd& w, const Execution& execution);

} // namespace difusa
