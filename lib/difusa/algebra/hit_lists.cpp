#include <difusa/algebra/hit_lists.h>

#include <difusa/algebra/transpose_sum.h>
#include <difusa/core/error.h>
#include <difusa/core/parallel.h>

#include <algorithm>
#include <bit>
#include <cstring>

namespace difusa {

namespace {

/// A row: the number of its bins (32 bits), the Rice parameter r (8 bits), then for each gap g from the previous bin
/// the quotient g >> r in unary (ones, then a zero) and the r low bits of g. A quotient of `escape` or more is written
/// as `escape` ones followed by all 32 bits of g.
constexpr unsigned escape = 24;
constexpr unsigned most_low_bits = 31; ///< shifting 32-bit gaps by 32 is undefined
constexpr std::size_t header = 5;
constexpr std::size_t slack = 8;

class BitWriter {
  public:
    explicit BitWriter(std::vector<std::uint8_t>& bytes) : bytes_(bytes) {}

    /// Appends the low `count` <= 32 bits.
    void put(std::uint64_t bits, unsigned count) {
        word_ |= bits << held_;
        held_ += count;
        while (held_ >= 8) {
            bytes_.push_back(static_cast<std::uint8_t>(word_));
            word_ >>= 8U;
            held_ -= 8;
        }
    }
    void flush() {
        if (held_ > 0) {
            bytes_.push_back(static_cast<std::uint8_t>(word_));
        }
        word_ = 0;
        held_ = 0;
    }

  private:
    std::vector<std::uint8_t>& bytes_;
    std::uint64_t word_ = 0;
    unsigned held_ = 0;
};

/// Calls `act(bin)` for each bin of the row that starts at `codes`.
template <class Act> void decode(const std::uint8_t* codes, const Act& act) {
    std::uint32_t count = 0;
    std::memcpy(&count, codes, sizeof count);
    const unsigned r = codes[4];
    const std::uint64_t low = (std::uint64_t{1} << r) - 1;
    const std::uint8_t* const bits = codes + header;
    std::size_t at = 0;
    std::uint32_t bin = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
        std::uint64_t word = 0;
        std::memcpy(&word, bits + (at >> 3U), sizeof word);
        word >>= at & 7U; // at least 57 bits are left: 24 + 32 are needed
        const auto ones = static_cast<unsigned>(std::countr_one(word));
        if (ones < escape) {
            word >>= ones + 1;
            bin += static_cast<std::uint32_t>((static_cast<std::uint64_t>(ones) << r) | (word & low));
            at += ones + 1 + r;
        } else {
            bin += static_cast<std::uint32_t>(word >> escape);
            at += escape + 32;
        }
        act(bin);
    }
}

} // namespace

HitLists::HitLists(std::size_t rows, std::size_t columns, std::size_t rays, std::size_t rows_per_block)
    : rows_(rows), columns_(columns), rays_(rays), rows_per_block_(rows_per_block),
      blocks_((rows + rows_per_block - 1) / rows_per_block) {
    DIFUSA_REQUIRE(rays > 0 && columns < none);
}

void HitLists::set(std::size_t j, std::vector<Index>& bins) {
    static_assert(std::endian::native == std::endian::little);
    DIFUSA_REQUIRE(bins.size() <= rays_);
    Block& block = blocks_[j / rows_per_block_];
    DIFUSA_REQUIRE(block.begin.size() == j % rows_per_block_, "rows of a block are set in order");
    std::sort(bins.begin(), bins.end());
    // The best parameter for geometrically distributed gaps, about log2 of 0.69 times their mean.
    const double mean = bins.empty() ? 0.0 : static_cast<double>(bins.back()) / static_cast<double>(bins.size());
    const unsigned r =
        mean < 1.5
            ? 0
            : std::min(most_low_bits, static_cast<unsigned>(std::bit_width(static_cast<std::uint32_t>(0.69 * mean))));
    block.codes.resize(block.codes.size() - (block.codes.empty() ? 0 : slack));
    block.begin.push_back(static_cast<std::uint32_t>(block.codes.size()));
    const auto count = static_cast<std::uint32_t>(bins.size());
    for (unsigned byte = 0; byte < 4; ++byte) {
        block.codes.push_back(static_cast<std::uint8_t>(count >> (8 * byte)));
    }
    block.codes.push_back(static_cast<std::uint8_t>(r));
    BitWriter writer(block.codes);
    Index before = 0;
    for (const Index bin : bins) {
        const Index gap = bin - before;
        before = bin;
        if (const Index quotient = gap >> r; quotient < escape) {
            writer.put((std::uint64_t{1} << quotient) - 1, quotient + 1);
            writer.put(gap & ((std::uint64_t{1} << r) - 1), r);
        } else {
            writer.put((std::uint64_t{1} << escape) - 1, escape);
            writer.put(gap, 32);
        }
    }
    writer.flush();
    block.codes.resize(block.codes.size() + slack, 0);
}

void HitLists::close_block(std::size_t first_row) {
    Block& block = blocks_[first_row / rows_per_block_];
    block.codes.shrink_to_fit();
    block.begin.shrink_to_fit();
}

void HitLists::row(std::size_t j, std::vector<Index>& bins) const {
    bins.clear();
    decode(codes_of(j), [&](Index bin) { bins.push_back(bin); });
}

std::size_t HitLists::bytes() const {
    std::size_t sum = 0;
    for (const Block& block : blocks_) {
        sum += sizeof(Block) + block.codes.capacity() + block.begin.capacity() * sizeof(std::uint32_t);
    }
    return sum;
}

void HitLists::apply(const Values& x, Values& y, const Execution& execution) const {
    DIFUSA_REQUIRE(static_cast<std::size_t>(x.rows()) == columns_);
    const Eigen::Index width = x.cols();
    y.resize(static_cast<Eigen::Index>(rows_), width);
    const double* const from = x.data();
    const double share = 1.0 / static_cast<double>(rays_);
    parallel_for(rows_, 64, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t j = begin; j < end; ++j) {
            double* const out = y.data() + static_cast<Eigen::Index>(j) * width;
            if (width == 1) {
                double sum = 0.0;
                decode(codes_of(j), [&](Index bin) { sum += from[bin]; });
                *out = share * sum;
            } else if (width == 3) {
                double sum[3] = {0.0, 0.0, 0.0};
                decode(codes_of(j), [&](Index bin) {
                    const double* const source = from + 3 * static_cast<std::size_t>(bin);
                    sum[0] += source[0];
                    sum[1] += source[1];
                    sum[2] += source[2];
                });
                for (Eigen::Index c = 0; c < 3; ++c) {
                    out[c] = share * sum[c];
                }
            } else {
                std::fill(out, out + width, 0.0);
                decode(codes_of(j), [&](Index bin) {
                    const double* const source = from + static_cast<Eigen::Index>(bin) * width;
                    for (Eigen::Index c = 0; c < width; ++c) {
                        out[c] += source[c];
                    }
                });
                for (Eigen::Index c = 0; c < width; ++c) {
                    out[c] *= share;
                }
            }
        }
    });
}

void HitLists::apply_transpose(const Values& x, Values& y, const Execution& execution) const {
    DIFUSA_REQUIRE(static_cast<std::size_t>(x.rows()) == rows_);
    sum_transposed(rows_, columns_, x.cols(), y, execution, [&](std::size_t j, Values& sum) {
        decode(codes_of(j), [&](Index bin) { sum.row(bin) += x.row(static_cast<Eigen::Index>(j)); });
    });
    y /= static_cast<double>(rays_);
}

} // namespace difusa
