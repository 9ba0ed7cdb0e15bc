// Products of lists of hits with many columns, a block of rows at a time: the operand is larger than the near caches,
// and the rows of points that are near each other need the same parts of it.
#pragma once

#include <difusa/algebra/wide_vectors.h>
#include <difusa/core/progress.h>
#include <difusa/core/types.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

namespace difusa {

/// The bins that the rays of some rows ended in, one row after the other.
struct BinsOfRows {
    std::vector<std::size_t> first{0}; ///< of each row in `bin`, and the end of the last
    std::vector<Index> bin;

    std::size_t size() const { return first.size() - 1; }
    std::span<const Index> operator[](std::size_t row) const {
        return std::span(bin).subspan(first[row], first[row + 1] - first[row]);
    }
};

/// Asks for `count` numbers, to have them in a near cache soon.
template <class Count, class Number> void fetch_ahead(const Count& count, const Number* numbers) {
    constexpr int line = 64 / sizeof(Number); // of a cache
    for (Eigen::Index c = 0; c < count; c += line) {
        __builtin_prefetch(numbers + c);
    }
}

constexpr int many_columns = 192; ///< are multiplied by a loop of their own

/// The sums of `count` columns for some rows, which begin at 0.
class SumsOfRows {
  public:
    void begin(std::size_t rows, std::size_t count) { lines_.assign((rows * count + line - 1) / line, {}); }
    double* data() { return lines_.front().number.data(); }

    /// Rows of `width` columns = `share` times the sums.
    template <class Count>
    void put(std::size_t rows, const Count& count, Eigen::Index width, double share, double* to) {
        for (std::size_t row = 0; row < rows; ++row) {
            const double* const sum = data() + row * static_cast<std::size_t>(count);
            double* const out = to + static_cast<Eigen::Index>(row) * width;
            for (Eigen::Index c = 0; c < count; ++c) {
                out[c] = share * sum[c];
            }
        }
    }

  private:
    static constexpr std::size_t line = 64 / sizeof(double);
    struct alignas(64) Line { ///< of a cache: vectors that lie across two of them take longer
        std::array<double, line> number;
    };

    std::vector<Line> lines_;
};

/// Calls `act(count, first column)` for all columns, with the widest vectors; the count is a constant for many.
template <class Act> void for_many_columns(Eigen::Index width, const Act& act) {
    Eigen::Index first = 0;
    for (; first + many_columns <= width; first += many_columns) {
        with_wide_vectors([&] { act(std::integral_constant<int, many_columns>(), first); });
    }
    if (first < width) {
        with_wide_vectors([&] { act(width - first, first); });
    }
}

/// So many hits of a row in turn, a run, are added up in the precision of the operand, in which their rounding errors
/// are like those of the operand, as they are few; sums of runs in double precision.
constexpr std::size_t hits_of_run = 8;

/// A product of many columns with a block of rows, as one thread. The runs of all rows are sorted by ranges of bins, so
/// that the bins of a range are read into a near cache once for all rows. The runs of a row stay in order, so that its
/// sums are those of the row alone. Their sums are read and written once for each run, so that they may be further
/// away: blocks may have many rows, for each of which all of the operand is read once.
template <class Number> class BlockProduct {
  public:
    /// As many blocks for each thread, with at most 2^20 hits each.
    static std::size_t rows_of_block(std::size_t all, std::size_t rays, const Execution& execution) {
        constexpr std::size_t most_hits = std::size_t{1} << 20U, most_rows = 2560;
        const std::size_t most = std::clamp<std::size_t>(most_hits / rays, 1, most_rows),
                          threads = std::max(1U, execution.threads),
                          blocks = threads * std::max<std::size_t>(1, (all + threads * most - 1) / (threads * most));
        return std::max<std::size_t>(1, (all + blocks - 1) / blocks);
    }

    /// `columns`: the number of bins.
    BlockProduct(BinsOfRows rows, std::size_t columns) : rows_(std::move(rows)) {
        const auto range_of = [](Index bin) { return bin >> range_bits; };
        const auto for_runs = [this](const auto& act) {
            for (std::size_t row = 0; row < rows_.size(); ++row) {
                for (std::size_t h = rows_.first[row]; h < rows_.first[row + 1]; h += hits_of_run) {
                    act(row, h);
                }
            }
        };
        std::vector<std::size_t> next(range_of(static_cast<Index>(columns)) + 2, 0);
        for_runs([&](std::size_t, std::size_t h) { ++next[range_of(rows_.bin[h]) + 1]; });
        std::partial_sum(next.begin(), next.end(), next.begin());
        runs_.resize(next.back());
        for_runs([&](std::size_t row, std::size_t h) {
            runs_[next[range_of(rows_.bin[h])]++] = {
                static_cast<std::uint32_t>(row), static_cast<std::uint32_t>(h),
                static_cast<std::uint32_t>(std::min(hits_of_run, rows_.first[row + 1] - h))};
        });
    }

    void multiply(const Number* from, Eigen::Index width, double share, double* to) {
        for_many_columns(width, [&](const auto& count, Eigen::Index first) {
            multiply_part(count, from + first, width);
            sums_.put(rows_.size(), count, width, share, to + first);
        });
    }

  private:
    static constexpr unsigned range_bits = 10;
    struct Run {
        std::uint32_t row, first, hits; ///< first: in `rows_.bin`
    };

    /// Columns 0 ... count - 1.
    template <class Count> void multiply_part(const Count& count, const Number* from, Eigen::Index width) {
        constexpr std::size_t ahead = 2; // runs
        const auto size = static_cast<std::size_t>(count);
        sums_.begin(rows_.size(), size);
        alignas(64) std::array<Number, many_columns> of_run{};
        Number* __restrict const part = of_run.data();
        for (std::size_t r = 0; r < runs_.size(); ++r) {
            const Run& run = runs_[r];
            for (Eigen::Index c = 0; c < count; ++c) {
                part[c] = 0;
            }
            for (std::uint32_t h = 0; h < run.hits; ++h) {
                if (r + ahead < runs_.size() && h < runs_[r + ahead].hits) {
                    fetch_ahead(count, from + static_cast<Eigen::Index>(rows_.bin[runs_[r + ahead].first + h]) * width);
                }
                const Number* const source = from + static_cast<Eigen::Index>(rows_.bin[run.first + h]) * width;
                one_term_at_a_time();
                for (Eigen::Index c = 0; c < count; ++c) {
                    part[c] += source[c];
                }
            }
            double* const sum = sums_.data() + run.row * size;
            for (Eigen::Index c = 0; c < count; ++c) {
                sum[c] += static_cast<double>(part[c]);
            }
        }
    }

    BinsOfRows rows_;
    std::vector<Run> runs_;
    SumsOfRows sums_;
};

} // namespace difusa
