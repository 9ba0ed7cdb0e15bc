#include <difusa/form_factors/closed_body.h>

#include <difusa/mesh/crossing_faces.h>

#include <algorithm>
#include <optional>
#include <unordered_map>
#include <utility>

namespace difusa {

namespace {

constexpr std::size_t most_comparisons = std::size_t{1} << 29U; ///< for all bodies: about a second
constexpr double single_rounding = 0x1p-21; ///< of distances between points in single precision, of the coordinates
constexpr double least_share = 1e-6;        ///< of a body's extent that matters
constexpr double least_turn = 1e-3;         ///< of an outline, to the right, that is not rounding

Plane plane_of(const Mesh& mesh, Index triangle) {
    return {mesh.normals[triangle], mesh.normals[triangle].dot(mesh.corner(triangle, 0))};
}

/// The largest coordinate.
double magnitude(const Eigen::AlignedBox3d& box) {
    return std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff());
}

/// The number of each key, in the order in which they are asked for.
class Numbering {
  public:
    Index of(Index key) { return number_.try_emplace(key, static_cast<Index>(number_.size())).first->second; }

  private:
    std::unordered_map<Index, Index> number_;
};

/// The triangles that can be reached from one across joined sides, if no side is left open. Sets #T `reached_from`.
std::optional<std::vector<Index>> closed_part(const Mesh& mesh, Index seed, std::vector<Index>& reached_from) {
    std::vector<Index> members{seed};
    reached_from[seed] = seed;
    bool closed = true;
    for (std::size_t at = 0; at < members.size(); ++at) {
        for (std::size_t side = 3 * std::size_t{members[at]}; side < 3 * std::size_t{members[at]} + 3; ++side) {
            const Index twin = mesh.twin[side];
            closed = closed && twin != none;
            if (twin != none && reached_from[twin / 3] == none) {
                reached_from[twin / 3] = seed;
                members.push_back(twin / 3);
            }
        }
    }
    return closed ? std::optional(std::move(members)) : std::nullopt;
}

/// Whether triangles enclose a volume behind their fronts. That of a sheet with two sides is rounding.
bool is_outward(const Mesh& mesh, const std::vector<Index>& triangles) {
    const Vec3& origin = mesh.corner(triangles.front(), 0);
    double volume = 0.0, area = 0.0;
    Eigen::AlignedBox3d box;
    for (const Index t : triangles) {
        const auto [a, b, c] = mesh.corners(t);
        volume += (a - origin).dot((b - origin).cross(c - origin)) / 6.0;
        area += mesh.areas[t];
        box.extend(a).extend(b).extend(c);
    }
    const double thickness = std::max(single_rounding * magnitude(box), least_share * box.diagonal().norm());
    return volume > thickness * area;
}

/// #T: numbers of the closed outward parts, or none, and how many there are.
std::pair<std::vector<Index>, Index> number_closed_parts(const Mesh& mesh) {
    std::vector<Index> number(mesh.triangles.size(), none), reached_from = number;
    Index count = 0;
    for (Index t = 0; t < number.size(); ++t) {
        if (reached_from[t] != none) {
            continue;
        }
        const std::optional<std::vector<Index>> triangles = closed_part(mesh, t, reached_from);
        if (triangles && is_outward(mesh, *triangles)) {
            for (const Index own : *triangles) {
                number[own] = count;
            }
            ++count;
        }
    }
    return {std::move(number), count};
}

} // namespace

ClosedBody::ClosedBody(const Mesh& mesh, const std::vector<Index>& triangles, const std::vector<Index>& faces,
                       std::size_t& comparisons) {
    Numbering corner, face;
    const auto number_of = [&](Index point) {
        const Index own = corner.of(point);
        if (own == corners_.size()) {
            corners_.push_back(mesh.points[point]);
        }
        return own;
    };
    for (const Index t : triangles) {
        if (face.of(faces[t]) == planes_.size()) {
            planes_.push_back(plane_of(mesh, t));
        }
    }
    for (const Index t : triangles) {
        for (std::size_t k = 0; k < 3; ++k) {
            const Index other = mesh.twin[3 * std::size_t{t} + k] / 3;
            if (t < other && faces[t] != faces[other]) {
                const Index from = number_of(mesh.triangles[t][k]), to = number_of(mesh.triangles[t][(k + 1) % 3]);
                edges_.push_back({from, to, face.of(faces[t]), face.of(faces[other])});
            }
        }
    }
    convex_ = is_convex(comparisons);
}

bool ClosedBody::is_convex(std::size_t& comparisons) const {
    Eigen::AlignedBox3d box;
    for (const Vec3& corner : corners_) {
        box.extend(corner);
    }
    const double rounding = std::min(single_rounding * magnitude(box), least_share * box.diagonal().norm());
    // Both ends of each face's neighbours first: other surfaces are soon done with.
    std::vector<std::vector<Index>> near(planes_.size());
    for (const Edge& edge : edges_) {
        near[edge.left].insert(near[edge.left].end(), {edge.from, edge.to});
        near[edge.right].insert(near[edge.right].end(), {edge.from, edge.to});
    }
    for (const Edge& edge : edges_) {
        for (const auto& [face, neighbour] : {std::pair(edge.left, edge.right), std::pair(edge.right, edge.left)}) {
            for (const Index corner : near[neighbour]) {
                if (planes_[face].height(corners_[corner]) > rounding) {
                    return false;
                }
            }
        }
    }
    const std::size_t needed = planes_.size() * corners_.size();
    if (needed > comparisons) {
        return false;
    }
    comparisons -= needed;
    return std::all_of(planes_.begin(), planes_.end(), [&](const Plane& plane) {
        return std::all_of(corners_.begin(), corners_.end(),
                           [&](const Vec3& corner) { return plane.height(corner) <= rounding; });
    });
}

bool ClosedBody::find_outline(const Vec3& x, double rounding, View& view) const {
    view.front.resize(planes_.size());
    for (std::size_t f = 0; f < planes_.size(); ++f) {
        view.front[f] = planes_[f].height(x) > rounding ? 1 : 0;
    }
    view.next.assign(corners_.size(), none);
    std::size_t count = 0;
    Index start = none;
    for (const Edge& edge : edges_) {
        if (view.front[edge.left] == view.front[edge.right]) {
            continue;
        }
        const bool left = view.front[edge.left] != 0;
        start = left ? edge.from : edge.to;
        if (view.next[start] != none) {
            return false;
        }
        view.next[start] = left ? edge.to : edge.from;
        ++count;
    }
    view.outline.clear();
    for (Index at = start; at != none && view.outline.size() < count; at = view.next[at]) {
        view.outline.push_back(at);
        const Index to = view.next[at], after = to == none ? none : view.next[to];
        if (after == none) {
            return false;
        }
        // The sine of the turn to the right at `to`, as seen from x.
        const Vec3 sight = corners_[to] - x, in = corners_[to] - corners_[at], out = corners_[after] - corners_[to];
        if (sight.dot(in.cross(out)) > least_turn * sight.norm() * in.norm() * out.norm()) {
            return false;
        }
        if (to == start) {
            return view.outline.size() == count;
        }
    }
    return false;
}

std::vector<std::shared_ptr<const ClosedBody>> closed_bodies(const Mesh& mesh, const std::vector<Index>& parts,
                                                             const Execution& execution) {
    std::vector<std::shared_ptr<const ClosedBody>> bodies(mesh.triangles.size());
    const auto [number, count] = number_closed_parts(mesh);
    std::vector<std::vector<Index>> members(count);
    Mesh closed; // of their triangles alone
    std::vector<Index> part_of;
    closed.points = mesh.points;
    for (Index t = 0; t < number.size(); ++t) {
        if (number[t] != none) {
            members[number[t]].push_back(t);
            closed.triangles.push_back(mesh.triangles[t]);
            part_of.push_back(number[t]);
        }
    }
    const auto crossings = find_crossing_triangles(closed, execution);
    if (!crossings) {
        return bodies;
    }
    std::vector<char> simple(count, 1);
    for (const auto& [s, t] : *crossings) {
        if (part_of[s] == part_of[t]) {
            simple[part_of[s]] = 0;
        }
    }
    std::size_t comparisons = most_comparisons;
    for (Index i = 0; i < count; ++i) {
        execution.check();
        if (simple[i] != 0) {
            const auto body = std::make_shared<const ClosedBody>(mesh, members[i], parts, comparisons);
            for (const Index own : members[i]) {
                bodies[own] = body;
            }
        }
    }
    return bodies;
}

} // namespace difusa
