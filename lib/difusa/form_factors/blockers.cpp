#include <difusa/form_factors/blockers.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

namespace difusa {

namespace {

constexpr std::size_t few_pieces = 12; ///< of a body

using Loop = std::vector<Index>; ///< numbers of points, counterclockwise

/// The boundary of the union of polygons whose insides do not overlap, if it is one simple loop: their edges without
/// those that occur in both directions.
std::optional<Loop> outline_of(const std::vector<const Loop*>& polygons) {
    std::map<std::pair<Index, Index>, int> edges;
    for (const Loop* polygon : polygons) {
        for (std::size_t k = 0; k < polygon->size(); ++k) {
            const Index a = (*polygon)[k], b = (*polygon)[(k + 1) % polygon->size()];
            const auto opposite = edges.find({b, a});
            if (opposite != edges.end()) {
                edges.erase(opposite);
            } else if (!edges.try_emplace({a, b}, 1).second) {
                return std::nullopt;
            }
        }
    }
    std::map<Index, Index> next;
    for (const auto& [edge, count] : edges) {
        if (!next.try_emplace(edge.first, edge.second).second) {
            return std::nullopt;
        }
    }
    if (next.empty()) {
        return std::nullopt;
    }
    Loop loop;
    for (Index at = next.begin()->first; loop.size() < next.size();) {
        loop.push_back(at);
        const auto step = next.find(at);
        if (step == next.end()) {
            return std::nullopt;
        }
        at = step->second;
        if (at == loop.front()) {
            break;
        }
    }
    return loop.size() == next.size() ? std::optional(loop) : std::nullopt;
}

/// The corners of a loop that are not on a straight line between others, if the loop is convex and has few enough.
std::optional<FlatPolygon> convex_corners(const Mesh& mesh, const Loop& loop, const Vec3& normal, double rounding) {
    const auto point = [&](std::size_t k) -> const Vec3& { return mesh.points[loop[k % loop.size()]]; };
    const auto outwards = [&](const Vec3& a, const Vec3& b, const Vec3& c) { // how far b is to the right of the line ac
        const Vec3 along = c - a;
        const double length = along.norm();
        return length > 0.0 ? normal.dot((b - a).cross(along)) / length : 0.0;
    };
    std::vector<Vec3> corners;
    for (std::size_t k = 0; k < loop.size(); ++k) {
        const double out = outwards(point(k + loop.size() - 1), point(k), point(k + 1));
        if (out < -rounding) {
            return std::nullopt;
        }
        if (out > rounding) {
            corners.push_back(point(k));
        }
    }
    if (corners.size() < 3 || corners.size() > Blocker::most_corners) {
        return std::nullopt;
    }
    for (std::size_t k = 0; k < corners.size(); ++k) { // a loop that turns left everywhere may still wind twice
        const Vec3 &a = corners[k], along = corners[(k + 1) % corners.size()] - a;
        const Vec3 inwards = normal.cross(along).normalized();
        for (const Vec3& p : corners) {
            if (inwards.dot(p - a) < -rounding) {
                return std::nullopt;
            }
        }
    }
    return FlatPolygon(corners);
}

/// The triangles of one flat part, merged two at a time as long as the union of neighbours is convex.
class FlatPartMerger {
  public:
    FlatPartMerger(const Mesh& mesh, const std::vector<Index>& triangles, double rounding)
        : mesh_(mesh), normal_(mesh.normals[triangles.front()]), rounding_(rounding) {
        for (const Index t : triangles) {
            const auto& corner = mesh.triangles[t];
            add({corner[0], corner[1], corner[2]});
        }
    }

    std::vector<FlatPolygon> merged() {
        std::vector<const Loop*> all;
        all.reserve(loops_.size());
        for (const Loop& loop : loops_) {
            all.push_back(&loop);
        }
        if (const auto outline = outline_of(all)) {
            if (const auto corners = convex_corners(mesh_, *outline, normal_, rounding_)) {
                return {*corners};
            }
        }
        while (merge_round()) {
        }
        std::vector<FlatPolygon> pieces;
        for (const Loop& loop : loops_) {
            if (!loop.empty()) {
                if (const auto corners = convex_corners(mesh_, loop, normal_, rounding_)) {
                    pieces.push_back(*corners);
                } else { // a triangle so thin that it is not above rounding
                    FlatPolygon thin;
                    for (const Index p : loop) {
                        thin.add(mesh_.points[p]);
                    }
                    pieces.push_back(thin);
                }
            }
        }
        return pieces;
    }

  private:
    void add(Loop loop) {
        own(loop, loops_.size());
        loops_.push_back(std::move(loop));
    }

    void own(const Loop& loop, std::size_t number) {
        for (std::size_t k = 0; k < loop.size(); ++k) {
            owner_[{loop[k], loop[(k + 1) % loop.size()]}] = number;
        }
    }

    /// Merges each polygon with the first neighbour it can be merged with. True if any was.
    bool merge_round() {
        bool any = false;
        for (std::size_t i = 0; i < loops_.size(); ++i) {
            for (std::size_t k = 0; k < loops_[i].size(); ++k) {
                const auto across = owner_.find({loops_[i][(k + 1) % loops_[i].size()], loops_[i][k]});
                // Where faces overlap, two polygons have the same edge: one of them may have been merged already.
                if (across == owner_.end() || across->second == i || loops_[across->second].empty()) {
                    continue;
                }
                const std::size_t j = across->second;
                auto outline = outline_of({&loops_[i], &loops_[j]});
                if (!outline || !convex_corners(mesh_, *outline, normal_, rounding_)) {
                    continue;
                }
                own(*outline, i);
                loops_[i] = std::move(*outline);
                loops_[j].clear();
                any = true;
                break;
            }
        }
        return any;
    }

    const Mesh& mesh_;
    Vec3 normal_;
    double rounding_;
    std::vector<Loop> loops_;                              ///< empty: merged with another
    std::map<std::pair<Index, Index>, std::size_t> owner_; ///< of directed edges; edges inside a polygon are stale
};

/// True if some point is above and some below the plane.
bool divides(const Plane& plane, const std::vector<Vec3>& points, double rounding) {
    bool above = false, below = false;
    for (const Vec3& p : points) {
        const double height = plane.height(p);
        above = above || height > rounding;
        below = below || height < -rounding;
        if (above && below) {
            return true;
        }
    }
    return false;
}

} // namespace

Blocker::Blocker(const FlatPolygon& corners) : polygon(corners) {
    const Vec3 normal = corners.area_vector().normalized();
    plane = {normal, normal.dot(corners.mean_corner())};
    low = high = corners[0];
    for (const Vec3& p : corners.corners()) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
    }
}

std::vector<Index> flat_parts(const Mesh& mesh) {
    const double rounding = plane_rounding(mesh);
    std::vector<Index> part(mesh.triangles.size(), none), open;
    Index count = 0;
    for (Index seed = 0; seed < part.size(); ++seed) {
        if (part[seed] != none) {
            continue;
        }
        const Plane plane{mesh.normals[seed], mesh.normals[seed].dot(mesh.corner(seed, 0))};
        const auto in_plane = [&](Index t) {
            return mesh.normals[t].dot(plane.normal) > 0.0 && std::abs(plane.height(mesh.corner(t, 0))) <= rounding &&
                   std::abs(plane.height(mesh.corner(t, 1))) <= rounding &&
                   std::abs(plane.height(mesh.corner(t, 2))) <= rounding;
        };
        open.assign(1, seed);
        part[seed] = count;
        while (!open.empty()) {
            const Index t = open.back();
            open.pop_back();
            for (Index k = 0; k < 3; ++k) {
                const Index side = mesh.twin[3 * t + k];
                if (side != none && part[side / 3] == none && in_plane(side / 3)) {
                    part[side / 3] = count;
                    open.push_back(side / 3);
                }
            }
        }
        ++count;
    }
    return part;
}

std::vector<Blocker> blockers_of(const Mesh& mesh, const std::vector<Index>& parts, const Execution& execution) {
    const double rounding = plane_rounding(mesh);
    std::vector<std::vector<Index>> members;
    for (Index t = 0; t < parts.size(); ++t) {
        if (parts[t] == members.size()) {
            members.emplace_back();
        }
        members[parts[t]].push_back(t);
    }
    const std::vector<std::shared_ptr<const ClosedBody>> bodies = closed_bodies(mesh, parts, execution);
    std::vector<Blocker> blockers;
    for (const std::vector<Index>& triangles : members) {
        const Index first = triangles.front();
        const Plane plane{mesh.normals[first], mesh.normals[first].dot(mesh.corner(first, 0))};
        if (!divides(plane, mesh.points, rounding)) {
            continue;
        }
        for (const FlatPolygon& piece : FlatPartMerger(mesh, triangles, rounding).merged()) {
            blockers.emplace_back(piece).body = bodies[first];
        }
    }
    return blockers;
}

Obstacle::Obstacle(std::span<const Blocker> pieces)
    : pieces_(pieces), body_(pieces[0].body && pieces[0].body->convex() ? pieces[0].body.get() : nullptr),
      low_(pieces[0].low), high_(pieces[0].high) {
    for (const Vec3& corner : corners()) { // of a body, also of faces that come between no two points
        low_ = low_.cwiseMin(corner);
        high_ = high_.cwiseMax(corner);
    }
}

bool Obstacle::rises_above(const Plane& plane, double rounding) const {
    const std::span<const Vec3> all = corners();
    return std::any_of(all.begin(), all.end(), [&](const Vec3& c) { return plane.height(c) > rounding; });
}

bool Obstacle::is_crossed(const Vec3& p, const Vec3& q, double rounding) const {
    if (body_ != nullptr) {
        return body_->is_crossed(p, q, rounding);
    }
    const Blocker& piece = pieces_[0];
    const double at_p = piece.plane.height(p), at_q = piece.plane.height(q);
    if (!((at_p > rounding && at_q < -rounding) || (at_p < -rounding && at_q > rounding))) {
        return false;
    }
    const Vec3 x = p + at_p / (at_p - at_q) * (q - p);
    const FlatPolygon& polygon = piece.polygon;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
        if ((polygon.next(k) - polygon[k]).cross(x - polygon[k]).dot(piece.plane.normal) < 0.0) {
            return false;
        }
    }
    return true;
}

ObstacleSet::ObstacleSet(std::vector<Blocker> blockers) : pieces_(std::move(blockers)) {
    const auto whole = [](const Blocker& piece) {
        return piece.body && piece.body->convex() ? piece.body.get() : nullptr;
    };
    // Bodies in the order of their first pieces.
    std::map<const ClosedBody*, std::size_t> first;
    std::vector<std::size_t> place(pieces_.size()), order(pieces_.size());
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
        const ClosedBody* const body = whole(pieces_[i]);
        place[i] = body != nullptr ? first.try_emplace(body, i).first->second : i;
    }
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return place[a] < place[b]; });
    std::vector<Blocker> sorted;
    sorted.reserve(pieces_.size());
    for (const std::size_t i : order) {
        sorted.push_back(std::move(pieces_[i]));
    }
    pieces_ = std::move(sorted);
    for (std::size_t i = 0, end = 0; i < pieces_.size(); i = end) {
        const ClosedBody* const body = whole(pieces_[i]);
        for (end = i + 1; body != nullptr && end < pieces_.size() && whole(pieces_[end]) == body; ++end) {
        }
        all_.emplace_back(std::span(pieces_).subspan(i, end - i));
    }
}

Obstruction obstruction(const Obstacle& obstacle, std::span<const Vec3> from, std::span<const Vec3> to,
                        double rounding) {
    const ClosedBody* const body = obstacle.body();
    if (body == nullptr) {
        return obstruction(obstacle.pieces()[0], from, to, rounding);
    }
    if (obstacle.pieces().size() <= few_pieces) { // one by one they leave less in doubt
        bool clear = true;
        for (const Blocker& piece : obstacle.pieces()) {
            const Obstruction what = obstruction(piece, from, to, rounding);
            if (what == Obstruction::complete) {
                return what;
            }
            clear = clear && what == Obstruction::clear;
        }
        if (clear) {
            return Obstruction::clear;
        }
    }
    return body->is_apart(from, to, rounding) ? Obstruction::clear
           : body->hides(from, to, rounding)  ? Obstruction::complete
                                              : Obstruction::partial;
}

Obstruction obstruction(const Blocker& blocker, std::span<const Vec3> from, std::span<const Vec3> to, double rounding) {
    constexpr std::size_t most = FlatPolygon::capacity;
    if (from.size() > most || to.size() > most) {
        return Obstruction::partial;
    }
    std::array<double, most> from_height, to_height; // NOLINT: filled before use
    double from_low = 0.0, from_high = 0.0, to_low = 0.0, to_high = 0.0;
    for (std::size_t i = 0; i < from.size(); ++i) {
        from_height[i] = blocker.plane.height(from[i]);
        from_low = i == 0 ? from_height[i] : std::min(from_low, from_height[i]);
        from_high = i == 0 ? from_height[i] : std::max(from_high, from_height[i]);
    }
    for (std::size_t j = 0; j < to.size(); ++j) {
        to_height[j] = blocker.plane.height(to[j]);
        to_low = j == 0 ? to_height[j] : std::min(to_low, to_height[j]);
        to_high = j == 0 ? to_height[j] : std::max(to_high, to_height[j]);
    }
    if ((from_low >= -rounding && to_low >= -rounding) || (from_high <= rounding && to_high <= rounding)) {
        return Obstruction::clear;
    }
    const bool down = from_low >= -rounding && to_high < -rounding, up = from_high <= rounding && to_low > rounding;
    const bool separates =
        down || up || (from_low > rounding && to_high <= rounding) || (from_high < -rounding && to_low >= -rounding);
    if (!separates) {
        return Obstruction::partial;
    }
    // Edge by edge: all crossing points outside one edge, or all inside all edges. What lies in the plane is not
    // hidden.
    bool all_inside = (from_low > rounding && to_high < -rounding) || (from_high < -rounding && to_low > rounding);
    std::array<double, most * most> part; // NOLINT: of the way at which each segment crosses; filled before use
    for (std::size_t i = 0; i < from.size(); ++i) {
        for (std::size_t j = 0; j < to.size(); ++j) {
            part[i * most + j] = std::clamp(from_height[i] / (from_height[i] - to_height[j]), 0.0, 1.0);
        }
    }
    const FlatPolygon& polygon = blocker.polygon;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
        const Vec3 along = polygon.next(k) - polygon[k];
        const Vec3 inwards = blocker.plane.normal.cross(along) / along.norm();
        const double offset = inwards.dot(polygon[k]);
        std::array<double, most> to_in; // NOLINT: filled before use
        for (std::size_t j = 0; j < to.size(); ++j) {
            to_in[j] = inwards.dot(to[j]) - offset;
        }
        bool any_inside = false;
        for (std::size_t i = 0; i < from.size(); ++i) {
            const double from_in = inwards.dot(from[i]) - offset;
            for (std::size_t j = 0; j < to.size(); ++j) {
                const double in = from_in + part[i * most + j] * (to_in[j] - from_in);
                any_inside = any_inside || in > rounding;
                all_inside = all_inside && in >= -rounding;
            }
        }
        if (!any_inside) {
            return Obstruction::clear;
        }
    }
    return all_inside ? Obstruction::complete : Obstruction::partial;
}

} // namespace difusa
