// A sparse matrix filled row by row by many threads and multiplied row by row, and the scratch that makes its rows.
#pragma once

#include <difusa/core/progress.h>
#include <difusa/core/types.h>

#include <bit>
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
        : sum_(columns, 0.0), used_((columns + 63) / 64, 0), used_words_((used_.size() + 63) / 64, 0) {}

    void add(Index column, double value) {
        const std::size_t word = column >> 6U;
        used_[word] |= std::uint64_t{1} << (column & 63U);
        used_words_[word >> 6U] |= std::uint64_t{1} << (word & 63U);
        sum_[column] += value;
    }

    /// Moves the sums into `row` and empties the accumulator.
    void take(SparseRows::Row& row);

  private:
    std::vector<double> sum_;
    std::vector<std::uint64_t> used_;       ///< a bit a column
    std::vector<std::uint64_t> used_words_; ///< a bit a word of `used_`
};

} // namespace difusa
