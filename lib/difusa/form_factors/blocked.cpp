#include <difusa/form_factors/blocked.h>

#include <difusa/rays/lambert.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace difusa {

namespace {

/// A rule that sees nothing of what a corner sees is wrong by this share of the difference at most: the part of a
/// triangle that a straight line cuts off beyond the points of the 7-point rule.
constexpr double corner_share = 1.0 / 6.0;

/// The mean of the form factor by some rule, and what its points saw.
struct MeanView {
    double mean = 0.0;
    unsigned seen = 0;
};

/// A part of the polygon that is integrated over.
struct OuterTriangle {
    Vec3 corner, first, second; ///< the other corners relative to the first
    double area;
    Estimate estimate;
};

bool less_error(const OuterTriangle& a, const OuterTriangle& b) {
    return a.estimate.error < b.estimate.error;
}

MeanView mean_view(const OuterTriangle& triangle, std::span<const TrianglePoint> rule, BlockedView& view) {
    MeanView result;
    for (const TrianglePoint& p : rule) {
        result.mean += p.weight * view.form_factor(triangle.corner + p.u * triangle.first + p.v * triangle.second);
        result.seen |= static_cast<unsigned>(view.seen());
    }
    return result;
}

/// The corners, moved inwards a little, off edges that touch the other polygon.
std::span<const TrianglePoint> corner_rule() {
    constexpr double in = 0x1p-20;
    static constexpr std::array<TrianglePoint, 3> corners{
        {{in, in, 1.0 / 3.0}, {1.0 - 2.0 * in, in, 1.0 / 3.0}, {in, 1.0 - 2.0 * in, 1.0 / 3.0}}};
    return corners;
}

/// True if all points saw everything, or all nothing.
bool unanimous(unsigned seen) {
    return seen == static_cast<unsigned>(Seen::everything) || seen == static_cast<unsigned>(Seen::nothing);
}

/// 7 points against 3 and the corners.
void integrate(OuterTriangle& triangle, const MeanView& three, const MeanView& corners, BlockedView& view) {
    const MeanView seven = mean_view(triangle, triangle_rule(7), view);
    double difference = std::abs(seven.mean - three.mean);
    if ((three.seen | seven.seen | corners.seen) != static_cast<unsigned>(Seen::part) &&
        !unanimous(three.seen | seven.seen | corners.seen)) {
        difference = std::max(difference, corner_share * std::abs(corners.mean - seven.mean));
    }
    triangle.estimate = {triangle.area * seven.mean, triangle.area * difference};
}

/// The first estimate of a triangle.
void start(OuterTriangle& triangle, double tolerance, BlockedView& view) {
    const MeanView one = mean_view(triangle, triangle_rule(1), view),
                   three = mean_view(triangle, triangle_rule(3), view),
                   corners = mean_view(triangle, corner_rule(), view);
    const double difference = std::abs(three.mean - one.mean);
    if (difference * triangle.area <= tolerance && unanimous(one.seen | three.seen | corners.seen)) {
        triangle.estimate = {triangle.area * three.mean, triangle.area * difference};
    } else {
        integrate(triangle, three, corners, view);
    }
}

std::array<OuterTriangle, 4> quarters(const OuterTriangle& whole) {
    const Vec3 a = 0.5 * whole.first, b = 0.5 * whole.second;
    const double area = 0.25 * whole.area;
    return {OuterTriangle{whole.corner, a, b, area, {}}, OuterTriangle{whole.corner + a, a, b, area, {}},
            OuterTriangle{whole.corner + b, a, b, area, {}}, OuterTriangle{whole.corner + a + b, -a, -b, area, {}}};
}

} // namespace

void BlockedView::set(const PolygonEnd& from, const PolygonEnd& to, std::span<const Blocker* const> blockers,
                      double rounding) {
    from_ = &from;
    to_ = &to;
    rounding_ = rounding;
    bodies_.clear();
    pieces_.clear();
    for (const Blocker* blocker : blockers) {
        bool front_only = false;
        if (blocker->body) {
            const Body& known = find(*blocker->body);
            if (known.by_outline) {
                continue;
            }
            front_only = known.outside;
        }
        const FlatPolygon before = blocker->polygon.above(from.plane, rounding).above(to.plane, rounding);
        if (!before.empty()) {
            pieces_.push_back({before, blocker->plane, front_only});
        }
    }
}

/// Looks at a body when one of its pieces is met first.
const BlockedView::Body& BlockedView::find(const ClosedBody& body) {
    const auto known =
        std::find_if(bodies_.rbegin(), bodies_.rend(), [&](const Body& each) { return each.body == &body; });
    if (known != bodies_.rend()) {
        return *known;
    }
    const auto least_height = [&](const Plane& plane) {
        double least = std::numeric_limits<double>::infinity();
        for (const Vec3& corner : body.corners()) {
            least = std::min(least, plane.height(corner));
        }
        return least;
    };
    // Where it stands on the plane, points of that may be inside of it.
    const double above = least_height(from_->plane);
    const bool convex = body.convex() && above >= -rounding_ && least_height(to_->plane) >= -rounding_;
    return bodies_.emplace_back(Body{&body, above > rounding_, convex});
}

void BlockedView::hide(const Vec3& x, const FlatPolygon& blocker, const Plane& plane) {
    if (visible_.hide(x, blocker, plane, rounding_)) {
        seen_ = Seen::part;
    }
}

void BlockedView::hide_behind(const Vec3& x, const ClosedBody& body) {
    const std::span<const Vec3> corners = body.corners();
    const bool found = body.find_outline(x, rounding_, view_);
    if (!view_.outside) { // below its base
        visible_.clear();
        return;
    }
    if (!found) {
        for (const auto& [a, b, c] : body.triangles()) {
            const FlatPolygon triangle(std::array<Vec3, 3>{corners[a], corners[b], corners[c]});
            const Vec3 normal = triangle.area_vector().normalized();
            hide(x, triangle, {normal, normal.dot(corners[a])});
        }
        return;
    }
    // A fan of polygons from one corner of the outline. They need not be flat: what they hide is the same.
    constexpr std::size_t more = Blocker::most_corners - 2;
    const std::vector<Index>& outline = view_.outline;
    for (std::size_t first = 1; first + 1 < outline.size(); first += more) {
        FlatPolygon part;
        part.add(corners[outline[0]]);
        for (std::size_t k = first; k <= std::min(first + more, outline.size() - 1); ++k) {
            part.add(corners[outline[k]]);
        }
        hide(x, part, {Vec3::Zero(), -1.0}); // seen from its front
    }
}

double BlockedView::form_factor(const Vec3& x) {
    visible_.set(to_->polygon);
    seen_ = Seen::everything;
    for (const Body& each : bodies_) {
        if (each.by_outline && !visible_.empty()) {
            hide_behind(x, *each.body);
        }
    }
    for (std::size_t k = 0; k < pieces_.size() && !visible_.empty(); ++k) {
        const Piece& piece = pieces_[k];
        if (!piece.front_only || piece.plane.height(x) > rounding_) {
            hide(x, piece.polygon, piece.plane);
        }
    }
    if (visible_.empty()) {
        seen_ = Seen::nothing;
    }
    double sum = 0.0;
    std::array<Vec3, FlatPolygon::capacity> seen; // NOLINT: filled before use
    visible_.for_pieces([&](const FlatPolygon& piece) {
        for (std::size_t k = 0; k < piece.size(); ++k) {
            seen[k] = piece[k] - x;
        }
        sum += lambert_sum(from_->plane.normal, {seen.data(), piece.size()});
    });
    return sum;
}

Estimate blocked_exchange(const PolygonEnd& P, const PolygonEnd& Q, std::span<const Blocker* const> blockers,
                          double rounding, double tolerance, BlockedView& view, std::size_t most_triangles) {
    const bool swap = Q.radius < P.radius;
    const PolygonEnd &from = swap ? Q : P, &to = swap ? P : Q;
    view.set(from, to, blockers, rounding);
    std::vector<OuterTriangle> open;
    Estimate sum;
    const FlatPolygon& outline = from.polygon;
    for (std::size_t k = 2; k < outline.size(); ++k) {
        const Vec3 a = outline[k - 1] - outline[0], b = outline[k] - outline[0];
        OuterTriangle triangle{outline[0], a, b, 0.5 * a.cross(b).dot(from.plane.normal), {}};
        if (!(triangle.area > 0.0)) {
            continue;
        }
        start(triangle, tolerance * triangle.area / from.area, view);
        sum += triangle.estimate;
        open.push_back(triangle);
    }
    std::size_t count = open.size();
    std::make_heap(open.begin(), open.end(), less_error);
    while (sum.error > tolerance && count + 3 <= most_triangles) {
        std::pop_heap(open.begin(), open.end(), less_error);
        const OuterTriangle whole = open.back();
        open.pop_back();
        sum.value -= whole.estimate.value;
        sum.error -= whole.estimate.error;
        for (OuterTriangle& part : quarters(whole)) {
            integrate(part, mean_view(part, triangle_rule(3), view), mean_view(part, corner_rule(), view), view);
            sum += part.estimate;
            open.push_back(part);
            std::push_heap(open.begin(), open.end(), less_error);
        }
        count += 3;
    }
    Estimate result; // anew: differences have left rounding in the running sum
    for (const OuterTriangle& triangle : open) {
        result += triangle.estimate;
    }
    return result;
}

} // namespace difusa
