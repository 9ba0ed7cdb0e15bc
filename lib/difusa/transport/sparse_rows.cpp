#include <difusa/transport/sparse_rows.h>

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
    std::size_t count = 0;
    for (std::size_t group = 0; group < used_words_.size(); ++group) {
        for (std::uint64_t words = used_words_[group]; words != 0; words &= words - 1) {
            count += static_cast<std::size_t>(
                std::popcount(used_[64 * group + static_cast<std::size_t>(std::countr_zero(words))]));
        }
    }
    row.column.clear();
    row.value.clear();
    row.column.reserve(count);
    row.value.reserve(count);
    for (std::size_t group = 0; group < used_words_.size(); ++group) {
        for (std::uint64_t words = used_words_[group]; words != 0; words &= words - 1) {
            const std::size_t word = 64 * group + static_cast<std::size_t>(std::countr_zero(words));
            for (std::uint64_t bits = used_[word]; bits != 0; bits &= bits - 1) {
                const std::size_t column = 64 * word + static_cast<std::size_t>(std::countr_zero(bits));
                row.column.push_back(static_cast<Index>(column));
                row.value.push_back(sum_[column]);
                sum_[column] = 0.0;
            }
            used_[word] = 0;
        }
        used_words_[group] = 0;
    }
}

} // namespace difusa
