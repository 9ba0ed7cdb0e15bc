#include <difusa/repair/merge_points.h>

#include <difusa/core/random.h>

#include <algorithm>
#include <bit>
#include <cstdint>

namespace difusa {

namespace {

std::uint64_t hash(const Vec3& point) {
    std::uint64_t h = 0;
    for (const double coordinate : point) {
        h = mix_bits(h ^ std::bit_cast<std::uint64_t>(coordinate + 0.0)); // -0 + 0 is 0
    }
    return h;
}

} // namespace

std::vector<Index> first_at_place(std::span<const Vec3> points, std::span<const char> used) {
    // Sorting short keys is much faster than sorting coordinates, which resolve ties between equal keys.
    struct Entry {
        std::uint64_t key;
        Index point;
    };
    std::vector<Entry> entries;
    entries.reserve(points.size());
    for (std::size_t p = 0; p < points.size(); ++p) {
        if (used[p] != 0) {
            entries.push_back({hash(points[p]), static_cast<Index>(p)});
        }
    }
    std::sort(entries.begin(), entries.end(),
              [](const Entry& a, const Entry& b) { return a.key < b.key || (a.key == b.key && a.point < b.point); });
    const auto before = [&](const Entry& a, const Entry& b) {
        const Vec3 &p = points[a.point], &q = points[b.point];
        for (int k = 0; k < 3; ++k) {
            if (p[k] != q[k]) {
                return p[k] < q[k];
            }
        }
        return a.point < b.point;
    };
    std::vector<Index> first(points.size(), none);
    for (auto begin = entries.begin(); begin != entries.end();) {
        auto end = std::find_if(begin, entries.end(), [&](const Entry& e) { return e.key != begin->key; });
        const bool one_place =
            std::all_of(begin, end, [&](const Entry& e) { return points[e.point] == points[begin->point]; });
        if (!one_place) {
            std::sort(begin, end, before);
        }
        for (auto entry = begin; entry != end; ++entry) {
            const bool repeats = entry != begin && points[(entry - 1)->point] == points[entry->point];
            first[entry->point] = repeats ? first[(entry - 1)->point] : entry->point;
        }
        begin = end;
    }
    return first;
}

} // namespace difusa
