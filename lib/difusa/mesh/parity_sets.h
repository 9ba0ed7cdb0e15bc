// Disjoint sets whose members are related by "same" or "opposite".
#pragma once

#include <difusa/core/types.h>

#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace difusa {

/// Union-find by size with path compression.
class ParitySets {
  public:
    struct Place {
        Index root;
        bool opposite; ///< whether the member is opposite to the root
    };

    explicit ParitySets(std::size_t count) : parent_(count), size_(count, 1), opposite_(count, 0) {
        std::iota(parent_.begin(), parent_.end(), Index{0});
    }

    Place find(Index member) {
        Index root = member;
        std::uint8_t opposite = 0;
        while (parent_[root] != root) {
            opposite ^= opposite_[root];
            root = parent_[root];
        }
        const bool result = opposite != 0;
        while (parent_[member] != root && member != root) {
            const Index next = parent_[member];
            const std::uint8_t rest = opposite ^ opposite_[member];
            parent_[member] = root;
            opposite_[member] = opposite;
            opposite = rest;
            member = next;
        }
        return {root, result};
    }

    /// Declares a and b opposite, or the same. False if that contradicts an earlier declaration.
    bool join(Index a, Index b, bool opposite) {
        Place x = find(a), y = find(b);
        if (x.root == y.root) {
            return (x.opposite != y.opposite) == opposite;
        }
        if (size_[x.root] < size_[y.root]) {
            std::swap(x, y);
        }
        parent_[y.root] = x.root;
        size_[x.root] += size_[y.root];
        opposite_[y.root] = static_cast<std::uint8_t>((x.opposite != y.opposite) != opposite);
        return true;
    }

  private:
    std::vector<Index> parent_, size_;
    std::vector<std::uint8_t> opposite_; ///< relative to the parent
};

} // namespace difusa
