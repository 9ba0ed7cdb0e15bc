// A sparse matrix whose entries have a value for each channel: what is seen in coloured mirrors.
#pragma once

#include <difusa/algebra/linear_operator.h>
#include <difusa/algebra/sparse_rows.h>

#include <utility>
#include <vector>

namespace difusa {

/// #rows by #columns, with one value per entry (grey) or three. Rows are independent, so threads may fill different
/// ones; columns ascend within a row.
///
/// Columns of what it is applied to have the channels in turn: column c is multiplied with the values of channel c
/// modulo 3. A single column stands for the brightest channel: it is multiplied with the largest value of each entry,
/// which bounds all three.
class ChannelRows final : public LinearOperator {
  public:
    /// `channels`: 1 or 3.
    ChannelRows(std::size_t rows, std::size_t columns, int channels)
        : rows_(rows), columns_(columns), channels_(channels) {}

    /// All entries row by row, for files: each has a value for each channel.
    struct Packed : SparseRows::Packed {
        int channels = 1;
    };

    /// Throws InputError, saying what is wrong, unless all values are from 0 to 1 and the columns of each row ascend
    /// below `columns`.
    explicit ChannelRows(const Packed& packed);

    Packed packed() const;

    std::size_t rows() const override { return rows_.size(); }
    std::size_t columns() const override { return columns_; }
    int channels() const { return channels_; }

    /// Sets row i to the sums of `entries` by column; sorts them. Grey: of the first channel.
    void set(std::size_t i, std::vector<std::pair<Index, Rgb>>& entries);

    /// Size in bytes.
    std::size_t bytes() const;
    std::size_t entry_count() const override;

    /// Throws InternalError unless x has one column or, if there are three channels, a multiple of three.
    void apply(const Values& x, Values& y, const Execution& execution) const override;
    void apply_transpose(const Values& x, Values& y, const Execution& execution) const override;

  private:
    /// The factors of entry k for each column of a matrix of this width.
    using Row = SparseRows::Row; ///< #entries times #channels values
    template <class Act> void for_each_factor(const Row& row, std::size_t k, Eigen::Index width, const Act& act) const;
    void check_width(const Values& x) const;

    std::vector<Row> rows_;
    std::size_t columns_;
    int channels_;
};

} // namespace difusa
