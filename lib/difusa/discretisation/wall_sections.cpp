#include <difusa/discretisation/wall_sections.h>

#include <difusa/core/box_tree.h>
#include <difusa/discretisation/separators.h>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>

namespace difusa {

namespace {

using Box = BoxTree::Box;

/// What the wall F has in common with the triangle T, if it is more than a point.
std::optional<WallSection> section(const Mesh& mesh, Index F, Index T, double rounding) {
    const Vec3 n = mesh.normals[T], foot = mesh.corner(T, 0);
    std::array<double, 3> height{};
    for (std::size_t k = 0; k < 3; ++k) {
        height[k] = n.dot(mesh.corner(F, static_cast<int>(k)) - foot);
    }
    std::array<Vec3, 6> met;
    std::size_t count = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t next = (k + 1) % 3;
        const Vec3 &p = mesh.corner(F, static_cast<int>(k)), &q = mesh.corner(F, static_cast<int>(next));
        if (std::abs(height[k]) <= rounding) {
            met[count++] = p;
        }
        if ((height[k] > rounding && height[next] < -rounding) || (height[k] < -rounding && height[next] > rounding)) {
            met[count++] = p + height[k] / (height[k] - height[next]) * (q - p);
        }
    }
    if (count < 2 ||
        std::max({height[0], height[1], height[2]}) - std::min({height[0], height[1], height[2]}) <= 2.0 * rounding) {
        return std::nullopt; // beside T, or in its plane
    }
    Vec3 a = met[0], b = met[1];
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t j = i + 1; j < count; ++j) {
            if ((met[j] - met[i]).squaredNorm() > (b - a).squaredNorm()) {
                a = met[i];
                b = met[j];
            }
        }
    }
    // The part within T, which the margin widens.
    double enter = 0.0, leave = 1.0;
    for (int k = 0; k < 3; ++k) {
        const Vec3& p = mesh.corner(T, k);
        const Vec3 inwards = n.cross(mesh.corner(T, (k + 1) % 3) - p).normalized();
        const double at_a = inwards.dot(a - p) + rounding, at_b = inwards.dot(b - p) + rounding;
        if (at_a < 0.0 && at_b < 0.0) {
            return std::nullopt;
        }
        if (at_a < 0.0) {
            enter = std::max(enter, at_a / (at_a - at_b));
        } else if (at_b < 0.0) {
            leave = std::min(leave, at_a / (at_a - at_b));
        }
    }
    if (!(enter < leave)) {
        return std::nullopt;
    }
    const Vec3 way = b - a;
    return WallSection{F, T, a + enter * way, a + leave * way};
}

} // namespace

std::vector<WallSection> wall_sections(const Mesh& mesh, const Execution& execution) {
    const std::vector<Separator> separators = find_separators(mesh);
    std::vector<WallSection> sections;
    if (separators.empty()) {
        return sections;
    }
    const double rounding = wall_rounding(mesh);
    std::vector<char> parted(mesh.region_count, 0);
    for (const Separator& separator : separators) {
        parted[separator.region] = 1;
    }
    std::vector<Box> boxes;
    std::vector<Index> items;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        if (parted[mesh.region[t]] != 0) {
            boxes.push_back(mesh.box(t));
            items.push_back(t);
        }
    }
    const BoxTree tree(std::move(boxes), std::move(items));
    std::vector<Index> met;
    for (std::size_t i = 0; i < separators.size(); ++i) {
        if (i % 1024 == 0) {
            execution.check();
        }
        const Index region = separators[i].region, wall = separators[i].triangle;
        const Vec3 margin = Vec3::Constant(rounding);
        const Box box = mesh.box(wall);
        met.clear();
        tree.visit(Box(box.min() - margin, box.max() + margin), [&](Index T, const Box&) {
            if (mesh.region[T] == region) {
                met.push_back(T);
            }
            return false;
        });
        std::sort(met.begin(), met.end());
        for (const Index T : met) {
            if (const auto found = section(mesh, wall, T, rounding)) {
                sections.push_back(*found);
            }
        }
    }
    return sections;
}

} // namespace difusa
