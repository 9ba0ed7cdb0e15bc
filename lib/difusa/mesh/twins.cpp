#include <difusa/mesh/twins.h>

#include <difusa/mesh/edges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

namespace difusa {

namespace {

using CornerIndices = std::vector<std::array<Index, 3>>;

/// A triangle at an edge, by the angle of its third corner around the edge.
struct Leaf {
    double angle;
    EdgeSide side;
};

Index number_of(const CornerIndices& triangles, Index low, const EdgeSide& side) {
    const Index from = side.forward ? low : side.high;
    const auto& t = triangles[side.triangle];
    return 3 * side.triangle + (t[0] == from ? 0U : t[1] == from ? 1U : 2U);
}

/// The triangles at an edge in the order in which a rotation around it (right-handed, from low to high) meets them.
std::vector<Leaf> around(const std::vector<Vec3>& points, const CornerIndices& triangles, Index low,
                         std::span<const EdgeSide> sides) {
    const Vec3& foot = points[low];
    const Vec3 along = (points[sides[0].high] - foot).stableNormalized();
    Vec3 x = Vec3::Zero(), y = Vec3::Zero();
    std::vector<Leaf> leaves;
    for (const EdgeSide& side : sides) {
        const auto& t = triangles[side.triangle];
        const Index third = t[0] != low && t[0] != side.high ? t[0] : t[1] != low && t[1] != side.high ? t[1] : t[2];
        const Vec3 to = points[third] - foot;
        const Vec3 out = to - to.dot(along) * along;
        if (leaves.empty()) {
            x = out.stableNormalized();
            y = along.cross(x);
        }
        const double angle = leaves.empty() ? 0.0 : std::atan2(out.dot(y), out.dot(x));
        leaves.push_back({angle < 0.0 ? angle + 2.0 * std::numbers::pi : angle, side});
    }
    // The front of a forward triangle faces ahead in the rotation, that of a backward one faces back: of two at one
    // angle, back to back, the backward one comes first.
    std::stable_sort(leaves.begin(), leaves.end(), [](const Leaf& a, const Leaf& b) {
        return a.angle != b.angle ? a.angle < b.angle : (!a.side.forward && b.side.forward);
    });
    return leaves;
}

} // namespace

std::vector<Index> join_sides(const std::vector<Vec3>& points, const CornerIndices& triangles) {
    std::vector<Index> twin(3 * triangles.size(), none);
    const Edges edges(triangles, points.size());
    edges.for_each([&](Index low, Index /*high*/, std::span<const EdgeSide> sides) {
        const auto join = [&](const EdgeSide& a, const EdgeSide& b) {
            const Index s = number_of(triangles, low, a), other = number_of(triangles, low, b);
            twin[s] = other;
            twin[other] = s;
        };
        if (sides.size() == 2) {
            if (sides[0].forward != sides[1].forward) {
                join(sides[0], sides[1]);
            }
        } else if (sides.size() > 2) {
            const std::vector<Leaf> leaves = around(points, triangles, low, sides);
            for (std::size_t i = 0; i < leaves.size(); ++i) {
                const EdgeSide &here = leaves[i].side, &next = leaves[(i + 1) % leaves.size()].side;
                if (here.forward && !next.forward) {
                    join(here, next);
                }
            }
        }
    });
    return twin;
}

} // namespace difusa
