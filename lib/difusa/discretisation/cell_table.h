// A hash table from the cells of a spatial grid, each split by region, to numbers 0, 1, 2, ... in the order in which
// cells are added.
#pragma once

#include <difusa/core/random.h>
#include <difusa/core/types.h>

#include <array>
#include <cstdint>
#include <vector>

namespace difusa {

/// Cell indices along x, y and z.
using Cell = std::array<std::int32_t, 3>;

class CellTable {
  public:
    struct Slot {
        Cell cell{};
        Index region = none;
        Index number = none;
    };

    /// The number of a cell, or `none`.
    Index find(const Cell& cell, Index region) const { return find_from(start(cell, region), cell, region); }

    /// The number of a cell, adding it if it is new.
    Index insert(const Cell& cell, Index region) {
        if (2 * (count_ + 1) > slots_.size()) {
            grow();
        }
        Slot& slot = slots_[place(cell, region)];
        if (slot.region == none) {
            slot = {cell, region, static_cast<Index>(count_++)};
        }
        return slot.number;
    }

    std::size_t count() const { return count_; }

    /// All slots; those with `region == none` are empty.
    const std::vector<Slot>& slots() const { return slots_; }

    // Where a search starts, and the search from there: two steps, so that memory can be prefetched in between.
    std::size_t start(const Cell& cell, Index region) const { return hash(cell, region) & (slots_.size() - 1); }
    void prefetch(std::size_t start) const { __builtin_prefetch(&slots_[start]); }
    Index find_from(std::size_t start, const Cell& cell, Index region) const {
        const std::size_t mask = slots_.size() - 1;
        for (std::size_t k = start;; k = (k + 1) & mask) {
            const Slot& slot = slots_[k];
            if (slot.region == none || (slot.region == region && slot.cell == cell)) {
                return slot.number;
            }
        }
    }

  private:
    static std::uint64_t hash(const Cell& cell, Index region) {
        const auto bits = [](std::int32_t x) { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(x)); };
        return mix_bits((bits(cell[0]) | (bits(cell[1]) << 32U)) +
                        0x9e3779b97f4a7c15ULL * (bits(cell[2]) | (static_cast<std::uint64_t>(region) << 32U)));
    }

    std::size_t place(const Cell& cell, Index region) const {
        const std::size_t mask = slots_.size() - 1;
        std::size_t k = start(cell, region);
        while (slots_[k].region != none && !(slots_[k].region == region && slots_[k].cell == cell)) {
            k = (k + 1) & mask;
        }
        return k;
    }

    void grow() {
        std::vector<Slot> old(2 * slots_.size());
        old.swap(slots_);
        for (const Slot& moved : old) {
            if (moved.region != none) {
                slots_[place(moved.cell, moved.region)] = moved;
            }
        }
    }

    std::vector<Slot> slots_ = std::vector<Slot>(1024); ///< open addressing; a power of two, at most half full
    std::size_t count_ = 0;
};

} // namespace difusa
