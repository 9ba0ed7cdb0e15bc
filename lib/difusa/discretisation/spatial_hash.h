// Points hashed by position: which points are within a fixed reach of a given one?
#pragma once

#include <difusa/core/parallel.h>
#include <difusa/core/random.h>
#include <difusa/core/types.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

namespace difusa {

/// A grid of cells twice as wide as the reach, so that a ball of that radius overlaps at most 8 of them. Each cell
/// hashes to the head of a linked list. The 64 cells of a block have adjacent heads: neighbours in space share cache
/// lines. Cells and regions that collide share a list, so callers must test the items they get; they may get an item
/// twice.
class SpatialHash {
  public:
    struct Item {
        Vec3 position;
        Index face;
        Index next; ///< in the same list
    };

    SpatialHash(const Vec3& origin, double reach)
        : origin_(origin), inverse_size_(0.5 / reach), heads_(block_size, none) {}

    std::size_t size() const { return items_.size(); }
    const Item& operator[](Index i) const { return items_[i]; }

    /// Appends `count` points: `point(i)` is the i-th as an item, `region_of(face)` the region of a face. The order
    /// within lists depends on the threads.
    template <class Point, class Region>
    void append(std::size_t count, const Point& point, const Region& region_of, const Execution& execution) {
        const std::size_t old = items_.size();
        items_.resize(old + count);
        const bool grows = heads_.size() < heads_per_item * items_.size();
        if (grows) {
            heads_.assign(std::max(block_size, std::bit_ceil(heads_per_item * items_.size())), none);
        }
        parallel_for(count, grain, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
            for (std::size_t i = begin; i < end; ++i) {
                items_[old + i] = point(i);
            }
        });
        const std::size_t first = grows ? 0 : old;
        parallel_for(
            items_.size() - first, grain, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
                for (std::size_t i = first + begin; i < first + end; ++i) {
                    Item& item = items_[i];
                    const Vec3 scaled = (item.position - origin_) * inverse_size_;
                    const std::size_t list =
                        list_of(floor_of(scaled[0]), floor_of(scaled[1]), floor_of(scaled[2]), region_of(item.face));
                    item.next =
                        std::atomic_ref<Index>(heads_[list]).exchange(static_cast<Index>(i), std::memory_order_relaxed);
                }
            });
    }

    /// Calls `test(i, item)` for a superset of the items of `region` within the reach of p until it returns true;
    /// returns whether it did.
    template <class Test> bool any_near(const Vec3& p, Index region, const Test& test) const {
        const Vec3 scaled = (p - origin_) * inverse_size_;
        constexpr double margin = 0.5 * (1.0 + 1e-6); // an item must not be lost to rounding
        const std::int32_t x0 = floor_of(scaled[0] - margin), x1 = floor_of(scaled[0] + margin);
        const std::int32_t y0 = floor_of(scaled[1] - margin), y1 = floor_of(scaled[1] + margin);
        const std::int32_t z0 = floor_of(scaled[2] - margin), z1 = floor_of(scaled[2] + margin);
        for (std::int32_t x = x0; x <= x1; ++x) {
            for (std::int32_t y = y0; y <= y1; ++y) {
                for (std::int32_t z = z0; z <= z1; ++z) {
                    for (Index i = heads_[list_of(x, y, z, region)]; i != none; i = items_[i].next) {
                        if (test(i, items_[i])) {
                            return true;
                        }
                    }
                }
            }
        }
        return false;
    }

    /// Mean length of the list containing an item.
    double crowding() const {
        double squares = 0.0;
        for (const Index head : heads_) {
            double length = 0.0;
            for (Index i = head; i != none; i = items_[i].next) {
                length += 1.0;
            }
            squares += length * length;
        }
        return squares / std::max(1.0, static_cast<double>(items_.size()));
    }

  private:
    static constexpr std::size_t block_size = 64;    ///< 4 cells along each axis
    static constexpr std::size_t heads_per_item = 4; ///< the surface passes through a third of a block's cells
    static constexpr std::size_t grain = 4096;

    static std::int32_t floor_of(double x) { return static_cast<std::int32_t>(std::floor(x)); }

    std::size_t list_of(std::int32_t x, std::int32_t y, std::int32_t z, Index region) const {
        const auto bits = [](std::int32_t c) { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(c)); };
        const std::uint64_t block = mix_bits((bits(x >> 2) | (bits(y >> 2) << 32U)) +
                                             0x9e3779b97f4a7c15ULL * (bits(z >> 2) | (std::uint64_t{region} << 32U)));
        // Coincident regions must not all share the same list of their blocks.
        const std::uint64_t within =
            ((bits(x) & 3U) | ((bits(y) & 3U) << 2U) | ((bits(z) & 3U) << 4U)) ^ (block >> 58U);
        return (block * block_size + within) & (heads_.size() - 1);
    }

    Vec3 origin_;
    double inverse_size_;
    std::vector<Index> heads_; ///< a power of two
    std::vector<Item> items_;
};

} // namespace difusa
