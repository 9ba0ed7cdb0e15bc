#include <difusa/form_factors/closed_body.h>

#include <difusa/mesh/crossing_faces.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>
#include <unordered_map>
#include <utility>

namespace difusa {

namespace {

constexpr std::size_t most_comparisons = std::size_t{1} << 29U; ///< for all bodies: about a second
constexpr double single_rounding = 0x1p-21; ///< of distances between points in single precision, of the coordinates
constexpr double least_share = 1e-6;        ///< of a body's extent that matters
constexpr double least_turn = 1e-3;         ///< of an outline, to the right, that is not rounding
constexpr int most_steps = 24;              ///< of the search for a plane between a body and points

Plane plane_of(const Mesh& mesh, Index triangle) {
    return {mesh.normals[triangle], mesh.normals[triangle].dot(mesh.corner(triangle, 0))};
}

/// The largest coordinate.
double magnitude(const Eigen::AlignedBox3d& box) {
    return std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff());
}

/// The point of a segment that is closest to the origin.
Vec3 closest_to_origin(const Vec3& p, const Vec3& q) {
    const Vec3 along = q - p;
    const double square = along.squaredNorm();
    return square > 0.0 ? Vec3(p + std::clamp(-p.dot(along) / square, 0.0, 1.0) * along) : p;
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
    if (convex_) {
        prepare_convex();
    }
}

void ClosedBody::prepare_convex() {
    for (const Vec3& corner : corners_) {
        centre_ += corner;
    }
    centre_ /= static_cast<double>(corners_.size());
    double highest = -std::numeric_limits<double>::infinity();
    for (const Plane& plane : planes_) {
        highest = std::max(highest, plane.height(centre_));
    }
    inner_ = std::max(0.0, -highest);
    columns_.resize(static_cast<Eigen::Index>(corners_.size()), 3);
    for (std::size_t k = 0; k < corners_.size(); ++k) {
        outer_ = std::max(outer_, (corners_[k] - centre_).norm());
        columns_.row(static_cast<Eigen::Index>(k)) = corners_[k];
    }
    for (int axis = 0; axis < 3; ++axis) {
        const auto along = [axis](const Vec3& a, const Vec3& b) { return a[axis] < b[axis]; };
        const auto [low, high] = std::minmax_element(corners_.begin(), corners_.end(), along);
        poles_[2 * static_cast<std::size_t>(axis)] = static_cast<Index>(low - corners_.begin());
        poles_[2 * static_cast<std::size_t>(axis) + 1] = static_cast<Index>(high - corners_.begin());
    }
    first_.assign(corners_.size() + 1, 0);
    for (const Edge& edge : edges_) {
        ++first_[edge.from + 1];
        ++first_[edge.to + 1];
    }
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    std::vector<Index> next(first_.begin(), first_.end() - 1);
    neighbour_.resize(first_.back());
    for (const Edge& edge : edges_) {
        neighbour_[next[edge.from]++] = edge.to;
        neighbour_[next[edge.to]++] = edge.from;
    }
}

bool ClosedBody::is_crossed(const Vec3& p, const Vec3& q, double rounding) const {
    const Vec3 from = p - centre_, to = q - centre_;
    const double inner = inner_ - rounding;
    if (inner > 0.0 && std::max(from.squaredNorm(), to.squaredNorm()) > outer_ * outer_ &&
        closest_to_origin(from, to).squaredNorm() < inner * inner) {
        return true;
    }
    double first = 0.0, last = 1.0; // what of the segment is inside
    for (const Plane& plane : planes_) {
        const double at_p = plane.height(p) + rounding, at_q = plane.height(q) + rounding;
        if (at_p >= 0.0 && at_q >= 0.0) {
            return false;
        }
        if (at_p >= 0.0) {
            first = std::max(first, at_p / (at_p - at_q));
        } else if (at_q >= 0.0) {
            last = std::min(last, at_p / (at_p - at_q));
        }
        if (first >= last) {
            return false;
        }
    }
    return first > 0.0 || last < 1.0;
}

bool ClosedBody::hides(std::span<const Vec3> from, std::span<const Vec3> to, double rounding) const {
    for (const Vec3& p : from) {
        for (const Vec3& q : to) {
            if (!is_crossed(p, q, rounding)) {
                return false;
            }
        }
    }
    return is_apart(from, {}, rounding) || is_apart(to, {}, rounding);
}

/// From a corner on to lower ones, as long as an edge leads to one: on a convex body to the lowest.
Index ClosedBody::lowest_corner(const Vec3& direction, Index start) const {
    Index lowest = start;
    double height = direction.dot(corners_[start]);
    for (bool lower = true; lower;) {
        lower = false;
        for (Index k = first_[lowest], last = first_[lowest + 1]; k < last; ++k) {
            if (const double at = direction.dot(corners_[neighbour_[k]]); at < height) {
                lowest = neighbour_[k];
                height = at;
                lower = true;
            }
        }
    }
    return lowest;
}

/// The lowest of the poles.
Index ClosedBody::low_corner(const Vec3& direction) const {
    return *std::min_element(poles_.begin(), poles_.end(),
                             [&](Index a, Index b) { return direction.dot(corners_[a]) < direction.dot(corners_[b]); });
}

bool ClosedBody::is_apart(std::span<const Vec3> points, std::span<const Vec3> others, double rounding) const {
    const auto highest = [&](const Vec3& direction) {
        const Vec3* found = nullptr;
        double height = 0.0;
        for (const std::span<const Vec3> some : {points, others}) {
            for (const Vec3& p : some) {
                if (const double at = direction.dot(p); found == nullptr || at > height) {
                    found = &p;
                    height = at;
                }
            }
        }
        return *found;
    };
    // The points of the body less these points make a convex set. Where the origin is outside of it, the direction of
    // a point of it that is closer and closer to the origin becomes the normal of a plane between the two.
    Vec3 mean = Vec3::Zero();
    for (const std::span<const Vec3> some : {points, others}) {
        for (const Vec3& p : some) {
            mean += p / static_cast<double>(points.size() + others.size());
        }
    }
    Vec3 closest = centre_ - mean;
    Index lowest = low_corner(closest);
    for (int step = 0; step < most_steps; ++step) {
        const double length = closest.norm();
        if (length <= rounding) {
            return false;
        }
        const Vec3 normal = closest / length;
        lowest = lowest_corner(normal, lowest);
        const Vec3 far = highest(normal), extreme = corners_[lowest] - far;
        if (normal.dot(extreme) >= -rounding) {
            // Where the body is convex but for rounding, no edge may lead on.
            return (columns_.col(0) * normal[0] + columns_.col(1) * normal[1] + columns_.col(2) * normal[2])
                       .minCoeff() >= normal.dot(far) - rounding;
        }
        closest = closest_to_origin(closest, extreme);
    }
    return false;
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
