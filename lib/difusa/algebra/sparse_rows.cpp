#include <difusa/algebra/sparse_rows.h>

#include <difusa/core/error.h>
#include <difusa/core/parallel.h>

#include <cstring>

namespace difusa {

std::size_t SparseRows::nonzeros() const {
    std::size_t count = 0;
    for (const Row& row : rows_) {
        count += row.column.size();
    }
    return count;
}

double SparseRows::row_sum(std::size_t i) const {
    double sum = 0.0;
    for (const double value : rows_[i].value) {
        sum += value;
    }
    return sum;
}

void SparseRows::multiply(const Values& x, Values& y, const Execution& execution) const {
    DIFUSA_REQUIRE(static_cast<std::size_t>(x.rows()) == columns_);
    const Eigen::Index channels = x.cols();
    y.resize(static_cast<Eigen::Index>(rows()), channels);
    const double* from = x.data();
    parallel_for(rows(), 64, Execution{execution.threads, nullptr}, [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t i = begin; i < end; ++i) {
            const Row& row = rows_[i];
            const std::size_t count = row.column.size();
            if (channels == 1) {
                // Four sums hide the latency of the additions; their order is fixed.
                double sum[4] = {0.0, 0.0, 0.0, 0.0};
                std::size_t k = 0;
                for (; k + 4 <= count; k += 4) {
                    for (std::size_t lane = 0; lane < 4; ++lane) {
                        sum[lane] += row.value[k + lane] * from[row.column[k + lane]];
                    }
                }
                for (; k < count; ++k) {
                    sum[0] += row.value[k] * from[row.column[k]];
                }
                y(static_cast<Eigen::Index>(i), 0) = (sum[0] + sum[1]) + (sum[2] + sum[3]);
                continue;
            }
            auto out = y.row(static_cast<Eigen::Index>(i));
            out.setZero();
            for (std::size_t k = 0; k < count; ++k) {
                const double* const source = from + static_cast<Eigen::Index>(row.column[k]) * channels;
                for (Eigen::Index c = 0; c < channels; ++c) {
                    out[c] += row.value[k] * source[c];
                }
            }
        }
    });
}

void RowAccumulator::take(SparseRows::Row& row) {
    column_.clear();
    value_.clear();
    for (std::size_t group = 0; group < used_.size(); group += 8) {
        std::uint64_t any = 0;
        std::memcpy(&any, &used_[group], 8);
        if (any == 0) {
            continue;
        }
        for (std::size_t b = group; b < group + 8; ++b) {
            if (used_[b] == 0) {
                continue;
            }
            used_[b] = 0;
            for (std::size_t column = b * block; column < (b + 1) * block; ++column) {
                if (sum_[column] != 0.0) {
                    column_.push_back(static_cast<Index>(column));
                    value_.push_back(sum_[column]);
                    sum_[column] = 0.0;
                }
            }
        }
    }
    row.column.assign(column_.begin(), column_.end()); // of just the right capacity
    row.value.assign(value_.begin(), value_.end());
}

} // namespace difusa
