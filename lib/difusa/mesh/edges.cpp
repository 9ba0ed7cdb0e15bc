#include <difusa/mesh/edges.h>

#include <difusa/mesh/parity_sets.h>

#include <algorithm>

namespace difusa {

Edges::Edges(std::span<const std::array<Index, 3>> triangles, std::size_t point_count)
    : sides_(3 * triangles.size()), first_(point_count + 1, 0) {
    // Counting by the lower end point leaves short ranges to sort, except around points with many triangles.
    for (const auto& triangle : triangles) {
        for (std::size_t k = 0; k < 3; ++k) {
            ++first_[std::min(triangle[k], triangle[(k + 1) % 3]) + 1];
        }
    }
    for (std::size_t p = 0; p < point_count; ++p) {
        first_[p + 1] += first_[p];
    }
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        for (std::size_t k = 0; k < 3; ++k) {
            const Index from = triangles[t][k], to = triangles[t][(k + 1) % 3];
            sides_[next[std::min(from, to)]++] = {std::max(from, to), static_cast<Index>(t), from < to};
        }
    }
    for (std::size_t p = 0; p < point_count; ++p) {
        std::sort(sides_.begin() + static_cast<std::ptrdiff_t>(first_[p]),
                  sides_.begin() + static_cast<std::ptrdiff_t>(first_[p + 1]),
                  [](const EdgeSide& a, const EdgeSide& b) {
                      return a.high < b.high || (a.high == b.high && a.triangle < b.triangle);
                  });
    }
}

std::vector<Index> non_manifold_points(const Edges& edges, std::span<const std::array<Index, 3>> triangles,
                                       std::size_t point_count) {
    // Every corner of a triangle is a member; corners at the same point belong together if their triangles share an
    // edge.
    const auto corner_at = [&](Index triangle, Index point) {
        const auto& t = triangles[triangle];
        return 3 * triangle + (t[0] == point ? 0U : t[1] == point ? 1U : 2U);
    };
    ParitySets corners(3 * triangles.size());
    edges.for_each([&](Index low, Index high, std::span<const EdgeSide> sides) {
        for (std::size_t i = 1; i < sides.size(); ++i) {
            corners.join(corner_at(sides[0].triangle, low), corner_at(sides[i].triangle, low), false);
            corners.join(corner_at(sides[0].triangle, high), corner_at(sides[i].triangle, high), false);
        }
    });
    std::vector<std::uint8_t> fans(point_count, 0);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        for (std::size_t k = 0; k < 3; ++k) {
            const auto corner = static_cast<Index>(3 * t + k);
            if (corners.find(corner).root == corner) {
                std::uint8_t& count = fans[triangles[t][k]];
                count = static_cast<std::uint8_t>(std::min(count + 1, 2));
            }
        }
    }
    std::vector<Index> result;
    for (std::size_t p = 0; p < point_count; ++p) {
        if (fans[p] > 1) {
            result.push_back(static_cast<Index>(p));
        }
    }
    return result;
}

} // namespace difusa
