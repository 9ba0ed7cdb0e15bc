#include <difusa/algebra/hit_lists.h>

#include <difusa/algebra/block_products.h>
#include <difusa/algebra/column_panels.h>
#include <difusa/algebra/transpose_sum.h>
#include <difusa/algebra/wide_vectors.h>
#include <difusa/core/error.h>
#include <difusa/core/parallel.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <type_traits>

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

/// The number of bins of the row that starts at `codes`.
std::uint32_t bin_count(const std::uint8_t* codes) {
    std::uint32_t count = 0;
    std::memcpy(&count, codes, sizeof count);
    return count;
}

/// Whether a code of this length, which `slack` bytes follow, is that of at most `rays` bins below `columns`.
bool is_sound_code(const std::uint8_t* codes, std::size_t length, std::size_t columns, std::size_t rays) {
    if (length < header) {
        return false;
    }
    const std::uint32_t count = bin_count(codes);
    const unsigned r = codes[4];
    if (count > rays || r > most_low_bits) {
        return false;
    }
    const std::uint64_t low = (std::uint64_t{1} << r) - 1;
    const std::size_t bits = 8 * (length - header);
    std::size_t at = 0;
    std::uint64_t bin = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
        if (at >= bits) {
            return false;
        }
        std::uint64_t word = 0;
        std::memcpy(&word, codes + header + (at >> 3U), sizeof word);
        word >>= at & 7U;
        const auto ones = static_cast<unsigned>(std::countr_one(word));
        if (ones < escape) {
            bin += (static_cast<std::uint64_t>(ones) << r) | ((word >> (ones + 1)) & low);
            at += ones + 1 + r;
        } else {
            bin += static_cast<std::uint32_t>(word >> escape);
            at += escape + 32;
        }
        if (bin >= columns) {
            return false;
        }
    }
    return (at + 7) / 8 == length - header;
}

/// Reads the bins of a row in turn.
class Decoder {
  public:
    explicit Decoder(const std::uint8_t* codes)
        : count_(bin_count(codes)), r_(codes[4]), low_((std::uint64_t{1} << r_) - 1), bits_(codes + header) {}

    std::uint32_t count() const { return count_; }
    Index next() {
        std::uint64_t word = 0;
        std::memcpy(&word, bits_ + (at_ >> 3U), sizeof word);
        word >>= at_ & 7U; // at least 57 bits are left: 24 + 32 are needed
        const auto ones = static_cast<unsigned>(std::countr_one(word));
        if (ones < escape) {
            word >>= ones + 1;
            bin_ += static_cast<std::uint32_t>((static_cast<std::uint64_t>(ones) << r_) | (word & low_));
            at_ += ones + 1 + r_;
        } else {
            bin_ += static_cast<std::uint32_t>(word >> escape);
            at_ += escape + 32;
        }
        return bin_;
    }

  private:
    std::uint32_t count_;
    unsigned r_;
    std::uint64_t low_;
    const std::uint8_t* bits_;
    std::size_t at_ = 0;
    Index bin_ = 0;
};

/// Calls `act(bin)` for each bin of the row that starts at `codes`.
template <class Act> void decode(const std::uint8_t* codes, Act act) {
    Decoder row(codes);
    for (std::uint32_t i = 0; i < row.count(); ++i) {
        act(row.next());
    }
}

/// Rows whose bins take turns: where one begins is known only when the one before it has been read, and meanwhile the
/// others go on.
constexpr std::size_t rows_at_once = 4;

/// Calls `act(row, bin)` for each bin of rows begin ... end - 1, of which there are at most `rows_at_once`; `row`
/// counts from 0. The bins of each row come in order.
template <class Codes, class Act>
void decode_rows(const Codes& codes, std::size_t begin, std::size_t end, const Act& act) {
    if (end - begin == rows_at_once) {
        Decoder a(codes(begin)), b(codes(begin + 1)), c(codes(begin + 2)), d(codes(begin + 3));
        const std::uint32_t all = std::min({a.count(), b.count(), c.count(), d.count()});
        for (std::uint32_t i = 0; i < all; ++i) {
            act(0, a.next());
            act(1, b.next());
            act(2, c.next());
            act(3, d.next());
        }
        const auto finish = [&](std::size_t row, Decoder& rest) {
            for (std::uint32_t i = all; i < rest.count(); ++i) {
                act(row, rest.next());
            }
        };
        finish(0, a);
        finish(1, b);
        finish(2, c);
        finish(3, d);
        return;
    }
    for (std::size_t j = begin; j < end; ++j) {
        decode(codes(j), [&](Index bin) { act(j - begin, bin); });
    }
}

/// Adds up `count` columns of the bins of a row, with sums of runs as in BlockProduct.
template <int count, class Number> class ColumnSums {
  public:
    /// The columns of the next bin.
    void add(const Number* source) {
        for (int c = 0; c < count; ++c) {
            of_run_[c] += source[c];
        }
        if (++hits_ % hits_of_run == 0) {
            for (int c = 0; c < count; ++c) {
                sum_[c] += static_cast<double>(of_run_[c]);
                of_run_[c] = 0;
            }
        }
    }
    void put(double share, double* to) const {
        for (int c = 0; c < count; ++c) {
            to[c] = share * (sum_[c] + static_cast<double>(of_run_[c]));
        }
    }

  private:
    std::size_t hits_ = 0;
    Number of_run_[count] = {};
    double sum_[count] = {};
};

/// Rows j = begin ... end - 1 of a product with `count` columns, all that there are; `codes(j)`: those of a row.
template <int count, class Codes, class Number>
void sum_rows(const Codes& codes, std::size_t begin, std::size_t end, const Number* from, double share, double* to) {
    for (std::size_t next = 0; begin < end; begin = next) {
        next = std::min(begin + rows_at_once, end);
        std::array<ColumnSums<count, Number>, rows_at_once> sums;
        decode_rows(codes, begin, next,
                    [&](std::size_t row, Index bin) { sums[row].add(from + static_cast<std::size_t>(count) * bin); });
        for (std::size_t j = begin; j < next; ++j) {
            sums[j - begin].put(share, to + count * j);
        }
    }
}

/// The bins of rows j = begin ... end - 1; `codes(j)`: those of a row.
template <class Codes> BinsOfRows bins_of_rows(const Codes& codes, std::size_t begin, std::size_t end) {
    BinsOfRows rows;
    for (std::size_t j = begin; j < end; ++j) {
        rows.first.push_back(rows.first.back() + bin_count(codes(j)));
    }
    rows.bin.resize(rows.first.back());
    for (std::size_t j = begin, next = 0; j < end; j = next) {
        next = std::min(j + rows_at_once, end);
        std::array<Index*, rows_at_once> to{};
        for (std::size_t row = j; row < next; ++row) {
            to[row - j] = rows.bin.data() + rows.first[row - begin];
        }
        decode_rows(codes, j, next, [&](std::size_t row, Index bin) { *to[row]++ = bin; });
    }
    return rows;
}

/// `to` = `share` times the sums of `count` columns over the bins. Several columns of all bins are more than fits in a
/// cache that is near, so they are fetched some bins ahead: with 24 columns that takes a quarter of the time.
template <int count, class Number>
void sum_columns(std::span<const Index> bins, const Number* from, Eigen::Index width, double share, double* to) {
    constexpr std::size_t ahead = 12;
    double sum[count] = {};
    for (std::size_t begin = 0; begin < bins.size(); begin += hits_of_run) {
        Number of_run[count] = {};
        for (std::size_t i = begin; i < std::min(begin + hits_of_run, bins.size()); ++i) {
            if (i + ahead < bins.size()) {
                fetch_ahead(std::integral_constant<int, count>(),
                            from + static_cast<Eigen::Index>(bins[i + ahead]) * width);
            }
            const Number* const source = from + static_cast<Eigen::Index>(bins[i]) * width;
            for (int c = 0; c < count; ++c) {
                of_run[c] += source[c];
            }
        }
        for (int c = 0; c < count; ++c) {
            sum[c] += static_cast<double>(of_run[c]);
        }
    }
    for (int c = 0; c < count; ++c) {
        to[c] = share * sum[c];
    }
}

constexpr Eigen::Index least_columns = 48; ///< for which products by blocks of rows pay

} // namespace

HitLists::HitLists(std::size_t rows, std::size_t columns, std::size_t rays, std::size_t rows_per_block)
    : rows_(rows), columns_(columns), rays_(rays), rows_per_block_(rows_per_block),
      blocks_((rows + rows_per_block - 1) / rows_per_block) {
    DIFUSA_REQUIRE(rays > 0 && columns < none);
}

HitLists::HitLists(const Packed& packed, const Execution& execution)
    : rows_(packed.row_bytes.size()), columns_(packed.columns), rays_(packed.rays),
      rows_per_block_(packed.rows_per_block) {
    if (rays_ == 0 || columns_ >= none || rows_per_block_ == 0) {
        throw InputError("the lists of hits state no rays, too many bins, or no rows per block");
    }
    std::vector<std::size_t> first(rows_ + 1, 0); // byte of each row
    for (std::size_t j = 0; j < rows_; ++j) {
        first[j + 1] = first[j] + packed.row_bytes[j];
    }
    if (first.back() != packed.codes.size()) {
        throw InputError("the lengths of the lists of hits do not add up to their bytes");
    }
    blocks_.resize((rows_ + rows_per_block_ - 1) / rows_per_block_);
    parallel_for(blocks_.size(), 64, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t b = begin; b < end; ++b) {
            Block& block = blocks_[b];
            const std::size_t from = b * rows_per_block_, to = std::min(rows_, from + rows_per_block_);
            if (first[to] - first[from] > std::numeric_limits<std::uint32_t>::max()) {
                throw InputError("the lists of hits have a block of more than 4 GiB");
            }
            block.codes.reserve(first[to] - first[from] + slack);
            block.codes.assign(packed.codes.data() + first[from], packed.codes.data() + first[to]);
            block.codes.resize(block.codes.size() + slack, 0);
            block.begin.reserve(to - from);
            for (std::size_t j = from; j < to; ++j) {
                block.begin.push_back(static_cast<std::uint32_t>(first[j] - first[from]));
                if (!is_sound_code(codes_of(j), packed.row_bytes[j], columns_, rays_)) {
                    throw InputError("the list of hits of point " + std::to_string(j) + " is not one");
                }
            }
        }
    });
}

std::size_t HitLists::bytes_of(std::size_t j) const {
    const Block& block = blocks_[j / rows_per_block_];
    const std::size_t next = j % rows_per_block_ + 1;
    return (next < block.begin.size() ? block.begin[next] : block.codes.size() - slack) - block.begin[next - 1];
}

HitLists::Packed HitLists::packed() const {
    Packed packed{columns_, rays_, rows_per_block_, {}, {}};
    packed.row_bytes.reserve(rows_);
    packed.codes.reserve(code_bytes());
    for (std::size_t j = 0; j < rows_; ++j) {
        packed.row_bytes.push_back(static_cast<std::uint32_t>(bytes_of(j)));
        packed.codes.insert(packed.codes.end(), codes_of(j), codes_of(j) + packed.row_bytes[j]);
    }
    return packed;
}

void HitLists::set(std::size_t j, std::vector<Index>& bins) {
    static_assert(std::endian::native == std::endian::little);
    DIFUSA_REQUIRE(bins.size() <= rays_);
    Block& block = blocks_[j / rows_per_block_];
    DIFUSA_REQUIRE(block.begin.size() == j % rows_per_block_, "rows of a block are set in order");
    if (!std::is_sorted(bins.begin(), bins.end())) {
        std::sort(bins.begin(), bins.end());
    }
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

void HitLists::copy(std::size_t j, const HitLists& from) {
    DIFUSA_REQUIRE(from.rays_ == rays_ && from.columns_ == columns_ && j < from.rows_);
    Block& block = blocks_[j / rows_per_block_];
    DIFUSA_REQUIRE(block.begin.size() == j % rows_per_block_, "rows of a block are set in order");
    block.codes.resize(block.codes.size() - (block.codes.empty() ? 0 : slack));
    block.begin.push_back(static_cast<std::uint32_t>(block.codes.size()));
    const std::uint8_t* const codes = from.codes_of(j);
    block.codes.insert(block.codes.end(), codes, codes + from.bytes_of(j));
    block.codes.resize(block.codes.size() + slack, 0);
}

void HitLists::close_block(std::size_t first_row) {
    Block& block = blocks_[first_row / rows_per_block_];
    block.codes.shrink_to_fit();
    block.begin.shrink_to_fit();
}

void HitLists::row(std::size_t j, std::vector<Index>& bins) const {
    bins.resize(bin_count(codes_of(j)));
    Index* next = bins.data();
    decode(codes_of(j), [&](Index bin) { *next++ = bin; });
}

std::size_t HitLists::bytes() const {
    std::size_t sum = 0;
    for (const Block& block : blocks_) {
        sum += sizeof(Block) + block.codes.capacity() + block.begin.capacity() * sizeof(std::uint32_t);
    }
    return sum;
}

std::size_t HitLists::entry_count() const {
    std::size_t sum = 0;
    for (std::size_t j = 0; j < rows_; ++j) {
        sum += bin_count(codes_of(j));
    }
    return sum;
}

std::size_t HitLists::code_bytes() const {
    std::size_t sum = 0;
    for (const Block& block : blocks_) {
        sum += block.codes.size() - (block.codes.empty() ? 0 : slack);
    }
    return sum;
}

void HitLists::apply(const Values& x, Values& y, const Execution& execution) const {
    multiply(x, y, execution);
}

void HitLists::apply_single(const SingleValues& x, Values& y, const Execution& execution) const {
    multiply(x, y, execution);
}

template <class Operand> void HitLists::multiply(const Operand& x, Values& y, const Execution& execution) const {
    DIFUSA_REQUIRE(static_cast<std::size_t>(x.rows()) == columns_);
    const Eigen::Index width = x.cols();
    using Product = BlockProduct<typename Operand::Scalar>;
    const auto* const from = x.data();
    y.resize(static_cast<Eigen::Index>(rows_), width);
    const double share = 1.0 / static_cast<double>(rays_);
    const auto codes = [this](std::size_t j) { return codes_of(j); };
    const Execution silent = execution.silent();
    if (width >= least_columns) {
        parallel_for(rows_, Product::rows_of_block(rows_, rays_, execution), silent,
                     [&](std::size_t begin, std::size_t end, unsigned) {
                         Product product(bins_of_rows(codes, begin, end), columns_);
                         product.multiply(from, width, share, y.row(static_cast<Eigen::Index>(begin)).data());
                     });
        return;
    }
    parallel_for(rows_, 16, silent, [&](std::size_t begin, std::size_t end, unsigned) {
        if (width == 1) {
            sum_rows<1>(codes, begin, end, from, share, y.data());
            return;
        }
        if (width == 3) {
            sum_rows<3>(codes, begin, end, from, share, y.data());
            return;
        }
        const BinsOfRows rows = bins_of_rows(codes, begin, end);
        for (std::size_t j = begin; j < end; ++j) {
            double* const out = y.data() + static_cast<Eigen::Index>(j) * width;
            for_panels<24, 21, 9, 7, 3, 1>(width, [&](auto count, Eigen::Index c) {
                with_wide_vectors([&] { sum_columns<count>(rows[j - begin], from + c, width, share, out + c); });
            });
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
