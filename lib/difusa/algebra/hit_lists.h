// A matrix whose rows are counts: entry (j, k) is how many of the N rays of point j ended in bin k, over N. A row is a
// sorted list of bins, stored as the gaps between them in Golomb-Rice codes: one or two bytes per ray, where a list of
// columns and values takes twelve.
#pragma once

#include <difusa/algebra/linear_operator.h>

#include <cstdint>
#include <span>
#include <vector>

namespace difusa {

class HitLists final : public LinearOperator {
  public:
    /// Allocates `rows` rows over `columns` bins, with `rays` rays per row. Threads may fill different blocks of
    /// `rows_per_block` rows, the rows of each block in order.
    HitLists(std::size_t rows, std::size_t columns, std::size_t rays, std::size_t rows_per_block);

    /// All rows as they are stored, for files.
    struct Packed {
        std::size_t columns = 0, rays = 0, rows_per_block = 0;
        std::vector<std::uint32_t> row_bytes; ///< #rows: length of the code of each
        std::vector<std::uint8_t> codes;      ///< of all rows, one after another
    };

    /// Throws InputError, saying what is wrong, unless each code is that of at most `rays` bins below `columns`, and
    /// ends where its row does.
    HitLists(const Packed& packed, const Execution& execution);

    Packed packed() const;

    std::size_t rows() const override { return rows_; }
    std::size_t columns() const override { return columns_; }
    std::size_t rays() const { return rays_; }
    std::size_t rows_per_block() const { return rows_per_block_; }

    /// Sets row j to the bins of its rays, given in any order, and sorts them. At most `rays` of them: rays that ended
    /// in no bin are omitted. Row j - 1 of its block must be set before.
    void set(std::size_t j, std::vector<Index>& bins);

    /// Sets row j to row j of other lists with as many rays, whose bins have the same numbers; as `set`.
    void copy(std::size_t j, const HitLists& from);

    /// Releases spare capacity of the blocks. To be called once all rows are set.
    void close_block(std::size_t first_row);

    /// The bins of row j in ascending order, each repeated as often as rays ended in it.
    void row(std::size_t j, std::vector<Index>& bins) const;

    /// Size in bytes.
    std::size_t bytes() const;

    /// Size in bytes of the codes of all rows alone.
    std::size_t code_bytes() const;

    void apply(const Values& x, Values& y, const Execution& execution) const override;
    void apply_single(const SingleValues& x, Values& y, const Execution& execution) const override;
    bool prefers_single() const override { return true; }
    void apply_transpose(const Values& x, Values& y, const Execution& execution) const override;
    std::size_t entry_count() const override;

  private:
    struct Block {
        std::vector<std::uint8_t> codes;  ///< 8 bytes longer than the codes, so that whole words can be read
        std::vector<std::uint32_t> begin; ///< of each row in `codes`
    };
    template <class Operand> void multiply(const Operand& x, Values& y, const Execution& execution) const;
    const std::uint8_t* codes_of(std::size_t j) const {
        const Block& block = blocks_[j / rows_per_block_];
        return block.codes.data() + block.begin[j % rows_per_block_];
    }
    std::size_t bytes_of(std::size_t j) const; ///< of the code of row j

    std::size_t rows_, columns_, rays_, rows_per_block_;
    std::vector<Block> blocks_;
};

} // namespace difusa
