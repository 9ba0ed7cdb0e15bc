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

SparseRows::SparseRows(const Packed& packed) : rows_(packed.row_entries.size()), columns_(packed.columns) {
    std::size_t sum = 0;
    for (const std::uint32_t entries : packed.row_entries) {
        sum += entries;
    }
    if (sum != packed.column.size() || sum != packed.value.size()) {
        throw InputError("the lengths of the rows do not add up to their entries");
    }
    std::size_t at = 0;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
        const auto entries = static_cast<std::ptrdiff_t>(packed.row_entries[i]);
        const auto column = packed.column.begin() + static_cast<std::ptrdiff_t>(at);
        const auto value = packed.value.begin() + static_cast<std::ptrdiff_t>(at);
        rows_[i].column.assign(column, column + entries);
        rows_[i].value.assign(value, value + entries);
        at += packed.row_entries[i];
        const std::vector<Index>& own = rows_[i].column;
        if (std::adjacent_find(own.begin(), own.end(), std::greater_equal<>()) != own.end() ||
            (!own.empty() && own.back() >= columns_) ||
            !std::all_of(value, value + entries, [](double entry) { return std::isfinite(entry); })) {
            throw InputError("row " + std::to_string(i) +
                             " has columns that do not ascend or do not exist, or values that are not finite");
        }
    }
}

SparseRows::Packed SparseRows::packed() const {
    Packed packed;
    packed.columns = columns_;
    packed.column.reserve(nonzeros());
    packed.value.reserve(nonzeros());
    for (const Row& row : rows_) {
        packed.row_entries.push_back(static_cast<std::uint32_t>(row.column.size()));
        packed.column.insert(packed.column.end(), row.column.begin(), row.column.end());
        packed.value.insert(packed.value.end(), row.value.begin(), row.value.end());
    }
    return packed;
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
