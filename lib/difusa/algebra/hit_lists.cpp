#include <difusa/algebra/hit_lists.h>

#include <difusa/algebra/transpose_sum.h>
#include <difusa/algebra/vector_blocks.h>
#include <difusa/core/error.h>
#include <difusa/core/parallel.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <numeric>
#include <string>

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

/// Whether a code of this length, which `slack` bytes follow, is that of at most `rays` bins below `columns`.
bool is_sound_code(const std::uint8_t* codes, std::size_t length, std::size_t columns, std::size_t rays) {
    if (length < header) {
        return false;
    }
    std::uint32_t count = 0;
    std::memcpy(&count, codes, sizeof count);
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

constexpr int line = 8; ///< of a cache, in numbers

/// Asks for `count` numbers.
template <int count> void fetch(const double* numbers) {
    for (int c = 0; c < count; c += line) {
        __builtin_prefetch(numbers + c);
    }
}

/// `to` = `share` times the sums of `count` columns over the bins. Several columns of all bins are more than fits in a
/// cache that is near, so they are fetched some bins ahead: with 24 columns that takes a quarter of the time.
template <int count>
void sum_columns(const std::vector<Index>& bins, const double* from, Eigen::Index width, double share, double* to) {
    constexpr std::size_t ahead = 12;
    double sum[count] = {};
    for (std::size_t i = 0; i < bins.size(); ++i) {
        if (i + ahead < bins.size()) {
            fetch<count>(from + static_cast<Eigen::Index>(bins[i + ahead]) * width);
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

/// A product of many columns with a block of rows, as one thread. Rows of points that are near each other end in the
/// same bins. So the hits of all rows are sorted into ranges of bins: each range is read into a near cache once, and
/// added to the rows there. The hits of a row stay in order, so that its sums are those of the row alone.
class BlockProduct {
  public:
    static constexpr Eigen::Index least_columns = 48; ///< for which sorting pays
    static constexpr std::size_t most_rows = 512;

    /// Rows whose hits and sums fit in a cache, if several blocks are left for each thread.
    static std::size_t rows(std::size_t all, std::size_t rays, const Execution& execution) {
        constexpr std::size_t most_hits = std::size_t{1} << 18U;
        const std::size_t for_each = all / (8 * static_cast<std::size_t>(std::max(1U, execution.threads)));
        return std::clamp<std::size_t>(std::min(for_each, most_hits / rays), 32, most_rows);
    }

    void begin() {
        hits_.clear();
        rows_ = 0;
    }
    void add_row(const std::uint8_t* codes) {
        decode(codes, [&](Index bin) { hits_.push_back({bin, rows_}); });
        ++rows_;
    }
    /// Of `columns` bins.
    void sort(std::size_t columns) {
        const auto range_of = [](Index bin) { return bin >> range_bits; };
        std::vector<std::size_t> next(range_of(static_cast<Index>(columns)) + 2, 0);
        for (const Hit& hit : hits_) {
            ++next[range_of(hit.bin) + 1];
        }
        std::partial_sum(next.begin(), next.end(), next.begin());
        sorted_.resize(hits_.size());
        for (const Hit& hit : hits_) {
            sorted_[next[range_of(hit.bin)]++] = hit;
        }
    }
    void multiply(const double* from, Eigen::Index width, double share, double* to) {
        Eigen::Index c = 0;
        for (; c + 96 <= width; c += 96) {
            multiply_part<96>(from + c, width, share, to + c);
        }
        for (; c + 24 <= width; c += 24) {
            multiply_part<24>(from + c, width, share, to + c);
        }
        for (; c + 3 <= width; c += 3) {
            multiply_part<3>(from + c, width, share, to + c);
        }
        for (; c < width; ++c) {
            multiply_part<1>(from + c, width, share, to + c);
        }
    }

  private:
    static constexpr unsigned range_bits = 6;
    struct Hit {
        Index bin, row;
    };
    template <int count> using Columns = Eigen::Matrix<double, count, 1>;

    template <int count> void multiply_part(const double* from, Eigen::Index width, double share, double* to) {
        constexpr std::size_t ahead = 16;
        sums_.assign(rows_ * count, 0.0);
        for (std::size_t h = 0; h < sorted_.size(); ++h) {
            if (h + ahead < sorted_.size()) {
                fetch<count>(from + static_cast<Eigen::Index>(sorted_[h + ahead].bin) * width);
            }
            const double* const source = from + static_cast<Eigen::Index>(sorted_[h].bin) * width;
            double* const sum = sums_.data() + static_cast<std::size_t>(sorted_[h].row) * count;
            Columns<count>::Map(sum) += Columns<count>::Map(source);
        }
        for (std::size_t row = 0; row < rows_; ++row) {
            Columns<count>::Map(to + static_cast<Eigen::Index>(row) * width) =
                share * Columns<count>::Map(sums_.data() + row * count);
        }
    }

    std::vector<Hit> hits_, sorted_;
    std::vector<double> sums_;
    Index rows_ = 0;
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

std::size_t HitLists::entry_count() const {
    std::size_t sum = 0;
    for (std::size_t j = 0; j < rows_; ++j) {
        std::uint32_t count = 0;
        std::memcpy(&count, codes_of(j), sizeof count);
        sum += count;
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
    const double* const from = x.data();
    const double share = 1.0 / static_cast<double>(rays_);
    if (width >= BlockProduct::least_columns) {
        const std::size_t block = BlockProduct::rows(rows_, rays_, execution);
        parallel_for(rows_, block, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
            BlockProduct product;
            product.begin();
            for (std::size_t j = begin; j < end; ++j) {
                product.add_row(codes_of(j));
            }
            product.sort(columns_);
            product.multiply(from, width, share, y.data() + static_cast<Eigen::Index>(begin) * width);
        });
        return;
    }
    parallel_for(rows_, 64, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
        std::vector<Index> bins;
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
                row(j, bins);
                Eigen::Index c = 0;
                for (; c + 24 <= width; c += 24) {
                    sum_columns<24>(bins, from + c, width, share, out + c);
                }
                for (; c + 8 <= width; c += 8) {
                    sum_columns<8>(bins, from + c, width, share, out + c);
                }
                for (; c < width; ++c) {
                    sum_columns<1>(bins, from + c, width, share, out + c);
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
