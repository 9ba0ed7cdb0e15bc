// A sparse matrix filled row by row by many threads and multiplied row by row, and the scratch that makes its rows.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/core/types.h>

#include <cstdint>
#include <span>
#include <vector>

namespace difusa {

/// #rows by #columns. Rows are independent, so that threads may fill different ones; columns ascend in a row.
class SparseRows {
  public:
    SparseRows() = default;
    SparseRows(std::size_t rows, std::size_t columns) : rows_(rows), columns_(columns) {}

    struct Row {
        std::vector<Index> column;
        std::vector<double> value;
    };

    std::size_t rows() const { return rows_.size(); }
    std::size_t columns() const { return columns_; }
    Row& row(std::size_t i) { return rows_[i]; }
    const Row& row(std::size_t i) const { return rows_[i]; }
    std::size_t nonzeros() const;
    double row_sum(std::size_t i) const;

    /// Bytes taken by the entries.
    std::size_t bytes() const { return nonzeros() * (sizeof(Index) + sizeof(double)); }

    /// y = A x for each column of x; y is resized. The same bits for any number of threads.
    void multiply(const Values& x, Values& y, const Execution& execution) const;

  private:
    std::vector<Row> rows_;
    std::size_t columns_ = 0;
};

/// Sums contributions to the columns of one row in any order, then gives them sorted. One per thread.
class RowAccumulator {
  public:
    explicit RowAccumulator(std::size_t columns)
        : sum_((columns + block - 1) / block * block, 0.0), used_((sum_.size() / block + 7) / 8 * 8, 0) {}

    void add(Index column, double value) {
        used_[column / block] = 1; // a plain store: nothing waits for what was there before
        sum_[column] += value;
    }

    /// Moves the sums that are not 0 into `row`, by column, and empties the accumulator.
    void take(SparseRows::Row& row);

  private:
    static constexpr std::size_t block = 16; ///< columns
    std::vector<double> sum_;
    std::vector<Index> column_; ///< the row while it is collected
    std::vector<double> value_;
    std::vector<std::uint8_t> used_; ///< 1 for each block with a contribution; a multiple of 8 long
};

} // namespace difusa
