// A sparse matrix filled row by row by many threads and multiplied row by row.
#pragma once

#include <difusa/algebra/linear_operator.h>

#include <cstdint>
#include <vector>

namespace difusa {

/// #rows by #columns. Rows are independent, so threads may fill different ones; columns are ascending within a row.
class SparseRows final : public LinearOperator {
  public:
    SparseRows() = default;
    SparseRows(std::size_t rows, std::size_t columns) : rows_(rows), columns_(columns) {}

    struct Row {
        std::vector<Index> column;
        std::vector<double> value;
    };

    /// All entries row by row, for files.
    struct Packed {
        std::size_t columns = 0;
        std::vector<std::uint32_t> row_entries; ///< #rows: number of entries of each
        std::vector<Index> column;              ///< #entries
        std::vector<double> value;              ///< #entries
    };

    /// Throws InputError, saying what is wrong, unless all values are finite and the columns of each row ascend below
    /// `columns`.
    explicit SparseRows(const Packed& packed);

    Packed packed() const;

    std::size_t rows() const override { return rows_.size(); }
    std::size_t columns() const override { return columns_; }
    Row& row(std::size_t i) { return rows_[i]; }
    const Row& row(std::size_t i) const { return rows_[i]; }
    std::size_t nonzeros() const;

    /// Size of the rows in bytes.
    std::size_t bytes() const { return nonzeros() * (sizeof(Index) + sizeof(double)) + rows() * sizeof(Row); }

    void apply(const Values& x, Values& y, const Execution& execution) const override;
    void apply_transpose(const Values& x, Values& y, const Execution& execution) const override;
    const SparseRows* entries() const override { return this; }
    std::size_t entry_count() const override { return nonzeros(); }

  private:
    std::vector<Row> rows_;
    std::size_t columns_ = 0;
};

/// Rows with `values` values for each entry, from the arrays of a file. Throws InputError, saying what is wrong, unless
/// the columns of each row ascend below packed.columns and all values are sound; `unsound` says what others are, "are
/// not finite".
std::vector<SparseRows::Row> unpacked_rows(const SparseRows::Packed& packed, std::size_t values,
                                           bool (*is_sound)(double), const char* unsound);

/// The reverse.
SparseRows::Packed packed_rows(const std::vector<SparseRows::Row>& rows, std::size_t columns);

} // namespace difusa
