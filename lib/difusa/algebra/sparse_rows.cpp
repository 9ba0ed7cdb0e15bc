#include <difusa/algebra/sparse_rows.h>

#include <difusa/algebra/transpose_sum.h>
#include <difusa/core/error.h>
#include <difusa/core/parallel.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <string>

namespace difusa {

std::vector<SparseRows::Row> unpacked_rows(const SparseRows::Packed& packed, std::size_t values,
                                           bool (*is_sound)(double), const char* unsound) {
    std::size_t sum = 0;
    for (const std::uint32_t entries : packed.row_entries) {
        sum += entries;
    }
    if (sum != packed.column.size() || sum * values != packed.value.size()) {
        throw InputError("the lengths of the rows do not add up to their entries");
    }
    std::vector<SparseRows::Row> rows(packed.row_entries.size());
    auto column = packed.column.begin();
    auto value = packed.value.begin();
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const auto entries = static_cast<std::ptrdiff_t>(packed.row_entries[i]);
        SparseRows::Row& row = rows[i];
        row.column.assign(column, column + entries);
        row.value.assign(value, value + entries * static_cast<std::ptrdiff_t>(values));
        column += entries;
        value += entries * static_cast<std::ptrdiff_t>(values);
        if (std::adjacent_find(row.column.begin(), row.column.end(), std::greater_equal<>()) != row.column.end() ||
            (!row.column.empty() && row.column.back() >= packed.columns) ||
            !std::all_of(row.value.begin(), row.value.end(), is_sound)) {
            throw InputError("row " + std::to_string(i) +
                             " has columns that do not ascend or do not exist, or values "
                             "that " +
                             unsound);
        }
    }
    return rows;
}

SparseRows::Packed packed_rows(const std::vector<SparseRows::Row>& rows, std::size_t columns) {
    SparseRows::Packed packed;
    packed.columns = columns;
    std::size_t entries = 0, values = 0;
    for (const SparseRows::Row& row : rows) {
        entries += row.column.size();
        values += row.value.size();
    }
    packed.column.reserve(entries);
    packed.value.reserve(values);
    for (const SparseRows::Row& row : rows) {
        packed.row_entries.push_back(static_cast<std::uint32_t>(row.column.size()));
        packed.column.insert(packed.column.end(), row.column.begin(), row.column.end());
        packed.value.insert(packed.value.end(), row.value.begin(), row.value.end());
    }
    return packed;
}

SparseRows::SparseRows(const Packed& packed)
    : rows_(unpacked_rows(
          packed, 1, [](double v) { return std::isfinite(v); }, "are not finite")),
      columns_(packed.columns) {}

SparseRows::Packed SparseRows::packed() const {
    return packed_rows(rows_, columns_);
}

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
