#include <difusa/mesh/borders.h>

#include <difusa/core/box_tree.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

namespace difusa {

namespace {

/// Of the extent: coordinates with six or seven digits, in decimals or as single-precision numbers, are off by less.
constexpr double border_rounding = 1e-6;

using SideEnds = std::pair<Index, Index>; ///< the lower point first

/// The sides that an odd number of triangles have.
std::vector<SideEnds> odd_sides(const Mesh& mesh, std::span<const Index> triangles) {
    std::vector<SideEnds> all;
    all.reserve(3 * triangles.size());
    for (const Index t : triangles) {
        for (std::size_t k = 0; k < 3; ++k) {
            all.emplace_back(std::minmax(mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]));
        }
    }
    std::sort(all.begin(), all.end());
    std::vector<SideEnds> odd;
    for (std::size_t i = 0, end = 0; i < all.size(); i = end) {
        for (end = i + 1; end < all.size() && all[end] == all[i]; ++end) {
        }
        if ((end - i) % 2 == 1) {
            odd.push_back(all[i]);
        }
    }
    return odd;
}

struct BorderPiece {
    Vec3 from, along; ///< `along` is a unit vector
    double length;
};

/// Where on `piece`, in lengths from its start, the segment from a to b lies on it, if it does for more than `margin`.
std::optional<std::array<double, 2>> shared_stretch(const BorderPiece& piece, Vec3 a, Vec3 b, double margin) {
    double start = (a - piece.from).dot(piece.along), end = (b - piece.from).dot(piece.along);
    if (start > end) {
        std::swap(a, b);
        std::swap(start, end);
    }
    const double first = std::max(start, 0.0), last = std::min(end, piece.length);
    if (last - first <= margin) {
        return std::nullopt;
    }
    for (const double t : {first, last}) {
        const Vec3 there = a + (t - start) / (end - start) * (b - a);
        if ((there - (piece.from + t * piece.along)).norm() > margin) {
            return std::nullopt;
        }
    }
    return std::array{first, last};
}

/// Whether everywhere along a length, but for gaps up to `margin`, an odd number of stretches lie.
bool odd_everywhere(const std::vector<std::array<double, 2>>& stretches, double length, double margin) {
    std::vector<double> ends{length};
    for (const auto& [first, last] : stretches) {
        ends.push_back(first);
        ends.push_back(last);
    }
    std::sort(ends.begin(), ends.end());
    double from = 0.0; // of a stretch where their number is even
    for (std::size_t passed = 0; passed < ends.size(); ++passed) {
        if (passed % 2 == 0 && ends[passed] - from > margin) {
            return false;
        }
        from = ends[passed];
    }
    return true;
}

} // namespace

bool has_border(const Mesh& mesh, std::span<const Index> triangles) {
    const std::vector<SideEnds> sides = odd_sides(mesh, triangles);
    if (sides.empty()) {
        return false;
    }
    Eigen::AlignedBox3d all;
    std::vector<Eigen::AlignedBox3d> boxes;
    std::vector<Index> numbers;
    for (const auto& [a, b] : sides) {
        numbers.push_back(static_cast<Index>(boxes.size()));
        boxes.emplace_back(mesh.points[a].cwiseMin(mesh.points[b]), mesh.points[a].cwiseMax(mesh.points[b]));
    }
    for (const Index t : triangles) {
        all.extend(mesh.box(t));
    }
    const double margin = border_rounding * all.diagonal().norm();
    const BoxTree tree(boxes, numbers);
    for (std::size_t i = 0; i < sides.size(); ++i) {
        const Vec3 &from = mesh.points[sides[i].first], way = mesh.points[sides[i].second] - from;
        const BorderPiece piece{from, way.stableNormalized(), way.norm()};
        std::vector<std::array<double, 2>> stretches;
        const Vec3 around = Vec3::Constant(margin);
        tree.visit({boxes[i].min() - around, boxes[i].max() + around}, [&](Index j, const Eigen::AlignedBox3d&) {
            if (j != i) {
                const auto& [a, b] = sides[j];
                if (const auto stretch = shared_stretch(piece, mesh.points[a], mesh.points[b], margin)) {
                    stretches.push_back(*stretch);
                }
            }
            return false;
        });
        if (!odd_everywhere(stretches, piece.length, margin)) {
            return true;
        }
    }
    return false;
}

} // namespace difusa
