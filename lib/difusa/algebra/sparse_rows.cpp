#include <difusa/algebra/sparse_rows.h>

#include <difusa/algebra/transpose_sum.h>
#include <difusa/core/error.h>
#include <difusa/core/parallel.h>

namespace difusa {

std::size_t SparseRows::nonzeros() const {
    std::size_t count = 0;
    for (const Row& row : rows_) {
        count += row.column.size();
    }
    return count;
}

void SparseRows::apply(const Values& x, Values& y, const Execution& execution) const {
    DIFUSA_REQUIRE(static_cast<std::size_t>(x.rows()) == columns_);
    const Eigen::Index width = x.cols();
    y.resize(static_cast<Eigen::Index>(rows()), width);
    const double* from = x.data();
    parallel_for(rows(), 64, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t i = begin; i < end; ++i) {
            const Row& row = rows_[i];
            auto out = y.row(static_cast<Eigen::Index>(i));
            out.setZero();
            for (std::size_t k = 0; k < row.column.size(); ++k) {
                const double* const source = from + static_cast<Eigen::Index>(row.column[k]) * width;
                for (Eigen::Index c = 0; c < width; ++c) {
                    out[c] += row.value[k] * source[c];
                }
            }
        }
    });
}

void SparseRows::apply_transpose(const Values& x, Values& y, const Execution& execution) const {
    DIFUSA_REQUIRE(static_cast<std::size_t>(x.rows()) == rows());
    sum_transposed(rows(), columns_, x.cols(), y, execution, [&](std::size_t i, Values& sum) {
        for (std::size_t k = 0; k < rows_[i].column.size(); ++k) {
            sum.row(rows_[i].column[k]) += rows_[i].value[k] * x.row(static_cast<Eigen::Index>(i));
        }
    });
}

} // namespace difusa
