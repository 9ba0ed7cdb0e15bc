#include <difusa/algebra/hit_lists.h>

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
#include <numeric>
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

/// The same with two rows, whose bins take turns: where one begins is known only when the one before it has been read,
/// and meanwhile the other row goes on.
template <class Act, class OtherAct>
void decode_both(const std::uint8_t* codes, const std::uint8_t* other_codes, Act act, OtherAct other_act) {
    Decoder row(codes), other(other_codes);
    const std::uint32_t both = std::min(row.count(), other.count());
    for (std::uint32_t i = 0; i < both; ++i) {
        act(row.next());
        other_act(other.next());
    }
    for (std::uint32_t i = both; i < row.count(); ++i) {
        act(row.next());
    }
    for (std::uint32_t i = both; i < other.count(); ++i) {
        other_act(other.next());
    }
}

/// Adds up `count` columns, all that there are, of the bins of a row; handed out by reference.
template <int count> class ColumnSums {
  public:
    explicit ColumnSums(const double* from) : from_(from) {}
    void operator()(Index bin) {
        const double* const source = from_ + static_cast<std::size_t>(count) * bin;
        for (int c = 0; c < count; ++c) {
            sum_[c] += source[c];
        }
    }
    void put(double share, double* to) const {
        for (int c = 0; c < count; ++c) {
            to[c] = share * sum_[c];
        }
    }

  private:
    const double* from_;
    double sum_[count] = {};
};

/// Rows j = begin ... end - 1 of a product with `count` columns; `codes(j)`: those of a row.
template <int count, class Codes>
void sum_rows(const Codes& codes, std::size_t begin, std::size_t end, const double* from, double share, double* to) {
    std::size_t j = begin;
    for (; j + 2 <= end; j += 2) {
        ColumnSums<count> sum(from), other(from);
        decode_both(
            codes(j), codes(j + 1), [&](Index bin) { sum(bin); }, [&](Index bin) { other(bin); });
        sum.put(share, to + count * j);
        other.put(share, to + count * (j + 1));
    }
    if (j < end) {
        ColumnSums<count> sum(from);
        decode(codes(j), [&](Index bin) { sum(bin); });
        sum.put(share, to + count * j);
    }
}

/// The bins of some rows, one row after the other.
struct Rows {
    std::vector<std::size_t> first{0}; ///< of each row in `bin`, and the end of the last
    std::vector<Index> bin;

    /// Rows j = begin ... end - 1; `codes(j)`: those of a row.
    template <class Codes> Rows(const Codes& codes, std::size_t begin, std::size_t end) {
        for (std::size_t j = begin; j < end; ++j) {
            first.push_back(first.back() + bin_count(codes(j)));
        }
        bin.resize(first.back());
        const auto put = [this](std::size_t row) {
            return [to = bin.data() + first[row]](Index next) mutable { *to++ = next; };
        };
        std::size_t row = 0;
        for (; row + 2 <= size(); row += 2) {
            decode_both(codes(begin + row), codes(begin + row + 1), put(row), put(row + 1));
        }
        if (row < size()) {
            decode(codes(begin + row), put(row));
        }
    }

    std::size_t size() const { return first.size() - 1; }
    std::span<const Index> operator[](std::size_t row) const {
        return std::span(bin).subspan(first[row], first[row + 1] - first[row]);
    }
};

/// Asks for `count` numbers.
template <class Count, class Number> void fetch(const Count& count, const Number* numbers) {
    constexpr int line = 64 / sizeof(Number); // of a cache
    for (Eigen::Index c = 0; c < count; c += line) {
        __builtin_prefetch(numbers + c);
    }
}

/// `to` = `share` times the sums of `count` columns over the bins. Several columns of all bins are more than fits in a
/// cache that is near, so they are fetched some bins ahead: with 24 columns that takes a quarter of the time.
template <int count>
void sum_columns(std::span<const Index> bins, const double* from, Eigen::Index width, double share, double* to) {
    constexpr std::size_t ahead = 12;
    double sum[count] = {};
    for (std::size_t i = 0; i < bins.size(); ++i) {
        if (i + ahead < bins.size()) {
            fetch(std::integral_constant<int, count>(), from + static_cast<Eigen::Index>(bins[i + ahead]) * width);
        }
        const double* const source = from + static_cast<Eigen::Index>(bins[i]) * width;
        for (int c = 0; c < count; ++c) {
            sum[c] += source[c];
        }
    }
    for (int c = 0; c < count; ++c) {
        to[c] = share * sum[c];
    }
}

constexpr Eigen::Index least_columns = 48; ///< for which BlockProduct pays

/// Rows of a BlockProduct: several blocks for each thread, with hits of about 4 MiB each.
std::size_t rows_of_block(std::size_t all, std::size_t rays, const Execution& execution) {
    constexpr std::size_t most_hits = std::size_t{1} << 18U, most_rows = 512;
    const std::size_t for_each = all / (8 * static_cast<std::size_t>(std::max(1U, execution.threads)));
    return std::clamp<std::size_t>(std::min(std::max<std::size_t>(for_each, 32), most_hits / rays), 1, most_rows);
}

/// A product of many columns with a block of rows, as one thread. Rows of points that are near each other end in the
/// same bins. So the hits of all rows are sorted into ranges of bins: each range is read into a near cache once, and
/// added to the rows there. The hits of a row stay in order, so that its sums are those of the row alone. Operands in
/// single precision are half as much to read; their sums are as those of double precision.
template <class Number> class BlockProduct {
  public:
    /// `columns`: the number of bins.
    BlockProduct(const Rows& rows, std::size_t columns) : rows_(rows.size()), sorted_(rows.bin.size()) {
        const auto range_of = [](Index bin) { return bin >> range_bits; };
        std::vector<std::size_t> next(range_of(static_cast<Index>(columns)) + 2, 0);
        for (const Index bin : rows.bin) {
            ++next[range_of(bin) + 1];
        }
        std::partial_sum(next.begin(), next.end(), next.begin());
        for (std::size_t row = 0; row < rows.size(); ++row) {
            for (const Index bin : rows[row]) {
                sorted_[next[range_of(bin)]++] = {bin, static_cast<Index>(row)};
            }
        }
    }

    void multiply(const Number* from, Eigen::Index width, double share, double* to) {
        Eigen::Index rest = 0; // the first column that is in no panel
        for_panels<192, 96>(width, [&](auto count, Eigen::Index c) {
            with_wide_vectors([&] { multiply_part(count, from + c, width, share, to + c); });
            rest = c + count;
        });
        if (rest < width) {
            with_wide_vectors([&] { multiply_part(width - rest, from + rest, width, share, to + rest); });
        }
    }

  private:
    static constexpr unsigned range_bits = 6;
    struct Entry {
        Index bin, row;
    };
    static constexpr std::size_t line = 64 / sizeof(double);
    struct alignas(64) Line { ///< of a cache: vectors that lie across two of them take longer
        std::array<double, line> number;
    };

    /// Columns 0 ... count - 1; best if the count is a constant.
    template <class Count>
    void multiply_part(const Count& count, const Number* from, Eigen::Index width, double share, double* to) {
        constexpr std::size_t ahead = 16;
        const auto size = static_cast<std::size_t>(count);
        sums_.assign((rows_ * size + line - 1) / line, {});
        double* const sums = sums_.front().number.data();
        for (std::size_t h = 0; h < sorted_.size(); ++h) {
            if (h + ahead < sorted_.size()) {
                fetch(count, from + static_cast<Eigen::Index>(sorted_[h + ahead].bin) * width);
            }
            const Number* const source = from + static_cast<Eigen::Index>(sorted_[h].bin) * width;
            double* const sum = sums + static_cast<std::size_t>(sorted_[h].row) * size;
            for (Eigen::Index c = 0; c < count; ++c) {
                sum[c] += static_cast<double>(source[c]);
            }
        }
        for (std::size_t row = 0; row < rows_; ++row) {
            const double* const sum = sums + row * size;
            double* const out = to + static_cast<Eigen::Index>(row) * width;
            for (Eigen::Index c = 0; c < count; ++c) {
                out[c] = share * sum[c];
            }
        }
    }

    std::size_t rows_;
    std::vector<Entry> sorted_;
    std::vector<Line> sums_;
};

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
    DIFUSA_REQUIRE(static_cast<std::size_t>(x.rows()) == columns_);
    const Eigen::Index width = x.cols();
    y.resize(static_cast<Eigen::Index>(rows_), width);
    if (width >= least_columns) {
        multiply_by_blocks(x, y, execution);
        return;
    }
    const double* const from = x.data();
    const double share = 1.0 / static_cast<double>(rays_);
    const auto codes = [this](std::size_t j) { return codes_of(j); };
    parallel_for(rows_, 16, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
        if (width == 1) {
            sum_rows<1>(codes, begin, end, from, share, y.data());
            return;
        }
        if (width == 3) {
            sum_rows<3>(codes, begin, end, from, share, y.data());
            return;
        }
        const Rows rows(codes, begin, end);
        for (std::size_t j = begin; j < end; ++j) {
            double* const out = y.data() + static_cast<Eigen::Index>(j) * width;
            for_panels<24, 21, 9, 7, 3, 1>(width, [&](auto count, Eigen::Index c) {
                with_wide_vectors([&] { sum_columns<count>(rows[j - begin], from + c, width, share, out + c); });
            });
        }
    });
}

template <class Operand>
void HitLists::multiply_by_blocks(const Operand& x, Values& y, const Execution& execution) const {
    const double share = 1.0 / static_cast<double>(rays_);
    const auto codes = [this](std::size_t j) { return codes_of(j); };
    parallel_for(rows_, rows_of_block(rows_, rays_, execution), execution.silent(),
                 [&](std::size_t begin, std::size_t end, unsigned) {
                     BlockProduct<typename Operand::Scalar> product(Rows(codes, begin, end), columns_);
                     product.multiply(x.data(), x.cols(), share, y.row(static_cast<Eigen::Index>(begin)).data());
                 });
}

void HitLists::apply_single(const SingleValues& x, Values& y, const Execution& execution) const {
    if (x.cols() < least_columns) {
        apply(Values(x.cast<double>()), y, execution);
        return;
    }
    DIFUSA_REQUIRE(static_cast<std::size_t>(x.rows()) == columns_);
    y.resize(static_cast<Eigen::Index>(rows_), x.cols());
    multiply_by_blocks(x, y, execution);
}

void HitLists::apply_transpose(const Values& x, Values& y, const Execution& execution) const {
    DIFUSA_REQUIRE(static_cast<std::size_t>(x.rows()) == rows_);
    sum_transposed(rows_, columns_, x.cols(), y, execution, [&](std::size_t j, Values& sum) {
        decode(codes_of(j), [&](Index bin) { sum.row(bin) += x.row(static_cast<Eigen::Index>(j)); });
    });
    y /= static_cast<double>(rays_);
}

} // namespace difusa
