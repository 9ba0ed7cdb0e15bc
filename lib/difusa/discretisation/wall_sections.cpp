#include <difusa/discretisation/wall_sections.h>

#include <difusa/discretisation/obstacles.h>
#include <difusa/discretisation/region_trees.h>
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

/// Where separators stand on the regions they part.
void sections_of_separators(const Mesh& mesh, const RegionTrees& trees, double rounding, const Execution& execution,
                            std::vector<WallSection>& sections) {
    const Vec3 margin = Vec3::Constant(rounding);
    std::vector<Index> met;
    std::size_t count = 0;
    for (const auto& [region, wall] : find_separators(mesh, trees, Unreported(execution))) {
        if (count++ % 1024 == 0) {
            execution.check();
        }
        const Box box = mesh.box(wall);
        met.clear();
        trees.triangles(region).visit(Box(box.min() - margin, box.max() + margin), [&](Index T, const Box&) {
            met.push_back(T);
            return false;
        });
        std::sort(met.begin(), met.end());
        for (const Index T : met) {
            if (const auto found = section(mesh, wall, T, rounding)) {
                sections.push_back(*found);
            }
        }
    }
}

/// Where a region stands on itself: at sides that nothing is joined to.
void sections_of_open_sides(const Mesh& mesh, const RegionTrees& trees, double rounding, const Execution& execution,
                            std::vector<WallSection>& sections) {
    const std::vector<Index> planes = planes_of_regions(mesh, trees, rounding);
    const Vec3 margin = Vec3::Constant(rounding);
    const auto joined = [&](Index U, Index T) {
        for (std::size_t side = 3 * std::size_t{U}; side < 3 * std::size_t{U} + 3; ++side) {
            if (mesh.twin[side] != none && mesh.twin[side] / 3 == T) {
                return true;
            }
        }
        return false;
    };
    const auto add = [&](Index wall, Index T) {
        const auto found = section(mesh, wall, T, rounding);
        if (found && (found->to - found->from).norm() > 16.0 * rounding) { // more than the margin makes of a corner
            sections.push_back(*found);
        }
    };
    for (Index U = 0; U < mesh.triangles.size(); ++U) {
        const Index* const twin = &mesh.twin[3 * std::size_t{U}];
        if (planes[mesh.region[U]] != none || (twin[0] != none && twin[1] != none && twin[2] != none)) {
            continue;
        }
        if (U % 1024 == 0) {
            execution.check();
        }
        const Box box = mesh.box(U);
        trees.triangles(mesh.region[U]).visit(Box(box.min() - margin, box.max() + margin), [&](Index T, const Box&) {
            if (T != U && !joined(U, T)) {
                add(U, T);
                add(T, U);
            }
            return false;
        });
    }
}

} // namespace

std::vector<WallSection> wall_sections(const Mesh& mesh, const Execution& execution) {
    std::vector<WallSection> sections;
    if (mesh.convex) {
        return sections;
    }
    const double rounding = wall_rounding(mesh);
    const RegionTrees trees(mesh);
    sections_of_separators(mesh, trees, rounding, execution, sections);
    sections_of_open_sides(mesh, trees, rounding, execution, sections);
    return sections;
}

} // namespace difusa
