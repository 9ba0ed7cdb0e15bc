#include <difusa/form_factors/blocked.h>

#include <difusa/core/fingerprint.h>
#include <difusa/rays/lambert.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>

namespace difusa {

namespace {

/// A rule that sees nothing of what a corner sees is wrong by this share of the difference at most: the part of a
/// triangle that a straight line cuts off beyond the points of the 7-point rule.
constexpr double corner_share = 1.0 / 6.0;

/// Shadow regions that are a smaller share of a triangle fall between the points of a rule, or on one that stands for
/// more than is in the shadow.
constexpr double resolved_share = 0.25;

/// Exact integrals over triangles that no shadow meets are computed to this share of the tolerance.
constexpr double exact_share = 1e-2;

/// A body with more corners is taken for its bounding box where its shadow may fall.
constexpr std::size_t most_corners_of_shadow = 16;

/// So many parts of a triangle are looked at, the largest.
constexpr std::size_t most_parts = 8;

/// Shadow regions that have less than this share of a triangle in common with it only touch it.
constexpr double least_touch = 0x1p-40;

/// Shadows that hide less than this share of the tolerance are not looked for.
constexpr double negligible_share = 0.1;

constexpr std::size_t no_body = std::numeric_limits<std::size_t>::max();

/// A polygon is divided along this many lines at most, the longest: further ones are found as the rules disagree.
constexpr std::size_t most_cuts = 8;

constexpr std::size_t most_outlines = std::size_t{1} << 14U; ///< that are kept

/// Lengths and distances below this share of a polygon's radius divide nothing.
constexpr double least_cut = 0x1p-20;

bool is_above(const ClosedBody& body, const Plane& plane, double height) {
    return std::all_of(body.corners().begin(), body.corners().end(),
                       [&](const Vec3& corner) { return plane.height(corner) > height; });
}

/// The length of what of the segment from p to q, in the plane of a polygon, is inside of it.
double length_inside(const FlatPolygon& polygon, const Vec3& normal, const Vec3& p, const Vec3& q) {
    double first = 0.0, last = 1.0;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
        const Vec3 inwards = normal.cross(polygon.next(k) - polygon[k]);
        const double at_p = inwards.dot(p - polygon[k]), at_q = inwards.dot(q - polygon[k]);
        if (at_p < 0.0 && at_q < 0.0) {
            return 0.0;
        }
        if (at_p < 0.0) {
            first = std::max(first, at_p / (at_p - at_q));
        } else if (at_q < 0.0) {
            last = std::min(last, at_p / (at_p - at_q));
        }
    }
    return std::max(0.0, last - first) * (q - p).norm();
}

/// The form factor by some rule, and what its points saw.
struct MeanView {
    double mean = 0.0, first = 0.0; ///< of the first point
    unsigned seen = 0;
};

/// A part of the polygon that is integrated over.
struct OuterTriangle {
    Vec3 corner, first, second; ///< the other corners relative to the first
    double area;
    Estimate estimate;

    std::array<Vec3, 3> corners() const { return {corner, corner + first, corner + second}; }
};

bool less_error(const OuterTriangle& a, const OuterTriangle& b) {
    return a.estimate.error < b.estimate.error;
}

MeanView mean_view(const OuterTriangle& triangle, std::span<const TrianglePoint> rule, BlockedView& view) {
    MeanView result;
    for (const TrianglePoint& p : rule) {
        const double factor = view.form_factor(triangle.corner + p.u * triangle.first + p.v * triangle.second);
        result.first = result.seen == 0 ? factor : result.first;
        result.mean += p.weight * factor;
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

/// What no point of the rules has noticed adds to the error; `negligible`: an area.
double missed(unsigned seen, double negligible, BlockedView& view) {
    view.notice(false);
    return seen == static_cast<unsigned>(Seen::nothing) ? 0.0 : view.unnoticed(negligible);
}

/// 7 points against 3, and against the centre and the corners, for two rules may agree by accident.
void integrate(OuterTriangle& triangle, const MeanView& three, const MeanView& corners, double negligible,
               BlockedView& view) {
    view.notice(true);
    const MeanView seven = mean_view(triangle, triangle_rule(7), view);
    const double quadratic = 0.75 * seven.first + 0.25 * corners.mean; // exact for polynomials of degree 2
    double difference = std::max(std::abs(seven.mean - three.mean), 0.25 * std::abs(seven.mean - quadratic));
    if ((three.seen | seven.seen | corners.seen) != static_cast<unsigned>(Seen::part) &&
        !unanimous(three.seen | seven.seen | corners.seen)) {
        difference = std::max(difference, corner_share * std::abs(corners.mean - seven.mean));
    }
    triangle.estimate = {triangle.area * seven.mean,
                         triangle.area * difference + missed(three.seen | seven.seen, negligible, view)};
}

/// The first estimate of a triangle.
void start(OuterTriangle& triangle, double tolerance, BlockedView& view) {
    if (!view.begin(triangle.corners())) {
        triangle.estimate = view.unobstructed(triangle.corners(), exact_share * tolerance);
        return;
    }
    const double negligible = negligible_share * tolerance;
    const MeanView corners = mean_view(triangle, corner_rule(), view);
    view.notice(true);
    const MeanView one = mean_view(triangle, triangle_rule(1), view),
                   three = mean_view(triangle, triangle_rule(3), view);
    const double difference = std::max(std::abs(three.mean - one.mean), std::abs(corners.mean - three.mean) / 3.0);
    if (difference * triangle.area <= tolerance && unanimous(one.seen | three.seen | corners.seen)) {
        const double unseen = missed(one.seen, negligible, view);
        if (difference * triangle.area + unseen <= tolerance) {
            triangle.estimate = {triangle.area * three.mean, triangle.area * difference + unseen};
            return;
        }
    }
    integrate(triangle, three, corners, negligible, view);
}

/// A later estimate, of a part of a triangle.
void refine(OuterTriangle& triangle, double tolerance, BlockedView& view) {
    if (!view.begin(triangle.corners())) {
        triangle.estimate = view.unobstructed(triangle.corners(), exact_share * tolerance);
        return;
    }
    const MeanView corners = mean_view(triangle, corner_rule(), view);
    view.notice(true);
    const MeanView three = mean_view(triangle, triangle_rule(3), view);
    integrate(triangle, three, corners, negligible_share * tolerance, view);
}

std::array<OuterTriangle, 4> quarters(const OuterTriangle& whole) {
    const Vec3 a = 0.5 * whole.first, b = 0.5 * whole.second;
    const double area = 0.25 * whole.area;
    return {OuterTriangle{whole.corner, a, b, area, {}}, OuterTriangle{whole.corner + a, a, b, area, {}},
            OuterTriangle{whole.corner + b, a, b, area, {}}, OuterTriangle{whole.corner + a + b, -a, -b, area, {}}};
}

} // namespace

void BlockedView::set(const PolygonEnd& from, const PolygonEnd& to, std::span<const Obstacle* const> obstacles,
                      double rounding) {
    from_ = &from;
    to_ = &to;
    rounding_ = rounding;
    bodies_.clear();
    wholes_.clear();
    pieces_.clear();
    cuts_.clear();
    shadows_.clear();
    cores_.clear();
    notices_ = false;
    frame_ = PlaneFrame(from);
    for (const Obstacle* obstacle : obstacles) {
        if (obstacle->body() == nullptr) {
            add(obstacle->pieces()[0]);
        } else if (hides_as_a_whole(*obstacle->body())) {
            wholes_.push_back(obstacle);
        } else {
            for (const Blocker& piece : obstacle->pieces()) {
                if (obstruction(piece, from.polygon.corners(), to.polygon.corners(), rounding) != Obstruction::clear) {
                    add(piece);
                }
            }
        }
    }
    std::stable_sort(cuts_.begin(), cuts_.end(), [](const Cut& a, const Cut& b) { return a.length > b.length; });
    cuts_.resize(std::min(cuts_.size(), most_cuts), {0.0, {}});
    shadows_.resize(blocker_count());
    cores_.resize(blocker_count());
    active_.resize(blocker_count());
    std::iota(active_.begin(), active_.end(), std::size_t{0});
    for (Body& body : bodies_) {
        // Where it stands on the plane, points of that may be inside of it, or of a room whose outside it is.
        body.outside = body.listed > 1 && is_above(*body.body, from.plane, rounding); // else nothing is gained
    }
}

/// True if what its outline hides is what it hides.
bool BlockedView::hides_as_a_whole(const ClosedBody& body) const {
    return is_above(body, to_->plane, -rounding_) &&
           (is_above(body, from_->plane, rounding_) || body.is_apart(from_->polygon.corners(), {}, -2.0 * rounding_));
}

void BlockedView::add(const Blocker& blocker) {
    std::size_t body = no_body;
    if (blocker.body) {
        body = number_of(*blocker.body);
        ++bodies_[body].listed;
    }
    const FlatPolygon before = blocker.polygon.above(from_->plane, rounding_).above(to_->plane, rounding_);
    if (!before.empty()) {
        add_cut(before, blocker.plane);
        pieces_.push_back({before, blocker.plane, body});
    }
}

void BlockedView::add_cut(const FlatPolygon& piece, const Plane& plane) {
    for (std::size_t k = 0; k < piece.size(); ++k) {
        const Vec3 &p = piece[k], &q = piece.next(k);
        if (std::abs(from_->plane.height(p)) > rounding_ || std::abs(from_->plane.height(q)) > rounding_) {
            continue;
        }
        const double aside = least_cut * from_->radius;
        const double length = length_inside(from_->polygon, from_->plane.normal, p, q);
        if (length > aside && !from_->polygon.above(plane, aside).empty() &&
            !from_->polygon.above(plane, aside, -1.0).empty()) {
            cuts_.push_back({length, plane});
            return;
        }
    }
}

std::vector<FlatPolygon> BlockedView::smooth_parts() const {
    std::vector<FlatPolygon> parts{from_->polygon}, divided;
    for (const Cut& cut : cuts_) {
        divided.clear();
        for (const FlatPolygon& part : parts) {
            const double aside = least_cut * from_->radius;
            const FlatPolygon above = part.above(cut.plane, aside), below = part.above(cut.plane, aside, -1.0);
            if (above.empty() || below.empty() || part.size() + 2 > FlatPolygon::capacity) {
                divided.push_back(part);
            } else {
                divided.push_back(above);
                divided.push_back(below);
            }
        }
        parts.swap(divided);
    }
    return parts;
}

std::size_t BlockedView::number_of(const ClosedBody& body) {
    for (std::size_t i = bodies_.size(); i > 0; --i) { // mostly the last
        if (bodies_[i - 1].body == &body) {
            return i - 1;
        }
    }
    bodies_.push_back({&body});
    return bodies_.size() - 1;
}

bool BlockedView::hide(const Vec3& x, const FlatPolygon& blocker, const Plane& plane) {
    const bool hides = visible_.hide(x, blocker, plane, rounding_);
    seen_ = hides ? Seen::part : seen_;
    return hides;
}

std::size_t BlockedView::SightHash::operator()(const Sight& sight) const {
    Fingerprint fingerprint;
    fingerprint.add(reinterpret_cast<std::uintptr_t>(sight.body)); // NOLINT: no order depends on it
    for (const double coordinate : sight.x) {
        fingerprint.add(coordinate);
    }
    return fingerprint.value();
}

/// Corners of the body; null if no outline is found. Valid until the next call.
const std::vector<Index>* BlockedView::outline_of(const ClosedBody& body, const Vec3& x) {
    if (outlines_.size() >= most_outlines) {
        outlines_.clear();
    }
    const auto [place, is_new] = outlines_.try_emplace({&body, {x[0], x[1], x[2]}});
    if (is_new && body.find_outline(x, rounding_, view_)) {
        place->second = view_.outline;
    }
    return place->second.empty() ? nullptr : &place->second;
}

/// Whether it hides something; nothing if no outline is found.
std::optional<bool> BlockedView::hide_behind(const Vec3& x, const ClosedBody& body) {
    const std::vector<Index>* const outline = outline_of(body, x);
    if (outline == nullptr) {
        return std::nullopt;
    }
    bool hides = false;
    const std::span<const Vec3> corners = body.corners();
    // A fan of polygons from one corner of the outline. They need not be flat: what they hide is the same.
    constexpr std::size_t more = Blocker::most_corners - 2;
    for (std::size_t first = 1; first + 1 < outline->size(); first += more) {
        FlatPolygon part;
        part.add(corners[(*outline)[0]]);
        for (std::size_t k = first; k <= std::min(first + more, outline->size() - 1); ++k) {
            part.add(corners[(*outline)[k]]);
        }
        hides = hide(x, part, {Vec3::Zero(), -1.0}) || hides; // seen from its front
    }
    return hides;
}

bool BlockedView::hide_behind(const Vec3& x, const Obstacle& whole) {
    if (const std::optional<bool> hides = hide_behind(x, *whole.body())) {
        return *hides;
    }
    bool hides = false;
    for (const Blocker& front : whole.pieces()) {
        if (front.plane.height(x) > rounding_) {
            hides = hide(x, front.polygon, front.plane) || hides;
        }
    }
    return hides;
}

bool BlockedView::hide_behind(const Vec3& x, std::size_t blocker) {
    if (blocker < wholes_.size()) {
        return hide_behind(x, *wholes_[blocker]);
    }
    const Piece& piece = pieces_[blocker - wholes_.size()];
    return (piece.body == no_body || !bodies_[piece.body].outside || piece.plane.height(x) > rounding_) &&
           hide(x, piece.polygon, piece.plane);
}

/// The form factor past a single convex body: that to the whole polygon less that to what the body hides, which is
/// convex, too. Nothing if no outline is found, or if what it hides has too many corners.
std::optional<double> BlockedView::factor_past(const Vec3& x, const ClosedBody& body) {
    const std::vector<Index>* const outline = outline_of(body, x);
    if (outline == nullptr) {
        return std::nullopt;
    }
    const std::span<const Vec3> corners = body.corners();
    FlatPolygon hidden = to_->polygon;
    bool cut = false;
    for (std::size_t k = 0; k < outline->size(); ++k) {
        const Vec3 from = corners[(*outline)[k]] - x, to = corners[(*outline)[k + 1 < outline->size() ? k + 1 : 0]] - x,
                   normal = to.cross(from);
        const double length = normal.norm();
        if (!(length > 0.0)) {
            continue;
        }
        const Plane side{normal / length, normal.dot(x) / length};
        const std::span<const Vec3> left = hidden.corners();
        if (std::all_of(left.begin(), left.end(), [&](const Vec3& corner) { return side.height(corner) >= 0.0; })) {
            continue;
        }
        cut = true;
        hidden = hidden.above(side, 0.0);
        if (hidden.empty()) {
            return factor_of(x, to_->polygon);
        }
        if (hidden.size() == FlatPolygon::capacity) {
            return std::nullopt;
        }
    }
    seen_ = cut ? Seen::part : Seen::nothing;
    return cut ? std::max(0.0, factor_of(x, to_->polygon) - factor_of(x, hidden)) : 0.0;
}

/// All of a polygon in front of `from`, nothing hidden.
double BlockedView::factor_of(const Vec3& x, const FlatPolygon& polygon) const {
    std::array<Vec3, FlatPolygon::capacity> seen; // NOLINT: filled before use
    for (std::size_t k = 0; k < polygon.size(); ++k) {
        seen[k] = polygon[k] - x;
    }
    return lambert_sum(from_->plane.normal, {seen.data(), polygon.size()});
}

double BlockedView::form_factor(const Vec3& x) {
    seen_ = Seen::everything;
    if (active_.size() == 1 && active_[0] < wholes_.size() && !leaves_out_) {
        if (const std::optional<double> factor = factor_past(x, *wholes_[active_[0]]->body())) {
            if (notices_ && seen_ != Seen::everything) {
                noticed_[0] = 1;
            }
            return *factor;
        }
    }
    visible_.set(to_->polygon);
    for (std::size_t k = 0; k < active_.size() && !visible_.empty(); ++k) {
        if ((!leaves_out_ || left_out_[k] == 0) && hide_behind(x, active_[k]) && notices_) {
            noticed_[k] = 1;
            if (Body* const body = body_of(active_[k])) {
                body->noticed = true;
            }
        }
    }
    if (visible_.empty()) {
        seen_ = Seen::nothing;
    }
    double sum = 0.0;
    visible_.for_pieces([&](const FlatPolygon& piece) { sum += factor_of(x, piece); });
    return sum;
}

BlockedView::Body* BlockedView::body_of(std::size_t blocker) {
    const std::size_t body = blocker < wholes_.size() ? no_body : pieces_[blocker - wholes_.size()].body;
    return body == no_body ? nullptr : &bodies_[body];
}

std::span<const Vec3> BlockedView::few_corners(std::span<const Vec3> corners) {
    if (corners.size() <= most_corners_of_shadow) {
        return corners;
    }
    Eigen::AlignedBox3d box;
    for (const Vec3& corner : corners) {
        box.extend(corner);
    }
    for (std::size_t k = 0; k < box_.size(); ++k) {
        box_[k] = box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(k));
    }
    return box_;
}

const ShadowRegion& BlockedView::shadow_of(std::size_t blocker, bool core) {
    Body* const body = body_of(blocker);
    std::vector<std::optional<ShadowRegion>>& own = core ? cores_ : shadows_;
    std::optional<ShadowRegion>& region = body == nullptr ? own[blocker] : core ? body->core : body->shadow;
    if (!region) {
        const std::span<const Vec3> corners = body != nullptr ? body->body->corners()
                                              : blocker < wholes_.size()
                                                  ? wholes_[blocker]->corners()
                                                  : pieces_[blocker - wholes_.size()].polygon.corners();
        region.emplace(frame_, *from_, core ? std::span(&to_->centre, 1) : to_->polygon.corners(),
                       few_corners(corners));
    }
    return *region;
}

bool BlockedView::begin(const std::array<Vec3, 3>& corners) {
    for (std::size_t k = 0; k < 3; ++k) {
        triangle_[k] = frame_.flat(corners[k]);
    }
    triangle_area_ = 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]).norm();
    active_.clear();
    touched_.clear();
    for (Body& body : bodies_) {
        body.noticed = false;
        body.touched.area = -1.0; // not known yet
    }
    for (std::size_t b = 0; b < blocker_count(); ++b) {
        Body* const body = body_of(b);
        if (body != nullptr && body->touched.area < 0.0) {
            body->touched = shadow_of(b).within(triangle_);
        }
        const ShadowRegion::Part part = body != nullptr ? body->touched : shadow_of(b).within(triangle_);
        if (part.area > least_touch * triangle_area_) {
            active_.push_back(b);
            touched_.push_back(part);
        }
    }
    noticed_.assign(active_.size(), 0);
    notices_ = false;
    return !active_.empty();
}

Estimate BlockedView::unobstructed(const std::array<Vec3, 3>& corners, double tolerance) const {
    FlatPolygon triangle;
    for (const Vec3& corner : corners) {
        triangle.add(corner);
    }
    return unblocked_exchange(PolygonEnd(triangle, from_->plane.normal), *to_, tolerance);
}

bool BlockedView::is_noticed(std::size_t active) {
    const Body* const body = body_of(active_[active]);
    return body != nullptr ? body->noticed : noticed_[active] != 0;
}

ShadowRegion::Part BlockedView::unresolved(std::size_t active) {
    ShadowRegion::Part part = touched_[active];
    if (!is_noticed(active) || part.area < resolved_share * triangle_area_) {
        return part;
    }
    part = shadow_of(active_[active], true).within(triangle_); // the outskirts are, but perhaps not where it hides most
    return part.area < resolved_share * triangle_area_ ? part : ShadowRegion::Part();
}

double BlockedView::most_hidden(const ShadowRegion::Part& part) {
    double most = 0.0;
    for (const PlaneFrame::Point& place : {part.centre, part.aside[0], part.aside[1], part.aside[2]}) {
        const Vec3 x = frame_.lifted(place);
        const double with = form_factor(x);
        leaves_out_ = true; // all of them: they may hide the same
        most = std::max(most, form_factor(x) - with);
        leaves_out_ = false;
    }
    return most;
}

double BlockedView::unnoticed(double negligible) {
    left_out_.assign(active_.size(), 0);
    parts_.clear();
    double together = 0.0;
    bool noticed = false;
    for (std::size_t k = 0; k < active_.size(); ++k) {
        const ShadowRegion::Part part = unresolved(k);
        if (!(part.area > 0.0)) {
            continue;
        }
        left_out_[k] = 1;
        const bool again = std::any_of(parts_.begin(), parts_.end(), [&](const ShadowRegion::Part& other) {
            return other.centre == part.centre; // another piece of a body, or the other side of a sheet
        });
        if (!again && part.area * factor_of(frame_.lifted(part.centre), to_->polygon) > negligible) {
            parts_.push_back(part);
            together += part.area;
            noticed = noticed || is_noticed(k);
        }
    }
    if (parts_.size() > 1 && noticed && together >= resolved_share * triangle_area_) {
        return 0.0;
    }
    std::stable_sort(parts_.begin(), parts_.end(), [](const auto& a, const auto& b) { return a.area > b.area; });
    double sum = 0.0, most = 0.0, looked_at = 0.0;
    for (std::size_t k = 0; k < std::min(parts_.size(), most_parts); ++k) {
        const double hidden = most_hidden(parts_[k]);
        sum += parts_[k].area * hidden;
        most = std::max(most, hidden);
        looked_at += parts_[k].area;
    }
    return std::min(sum + (together - looked_at) * most, std::min(together, triangle_area_) * most);
}

Estimate blocked_exchange(const PolygonEnd& P, const PolygonEnd& Q, std::span<const Obstacle* const> obstacles,
                          double rounding, double tolerance, BlockedView& view, const Execution& execution,
                          std::size_t most_triangles) {
    const bool swap = Q.radius < P.radius;
    const PolygonEnd &from = swap ? Q : P, &to = swap ? P : Q;
    view.set(from, to, obstacles, rounding);
    std::vector<OuterTriangle> open;
    Estimate sum;
    for (const FlatPolygon& outline : view.smooth_parts()) {
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
    }
    std::size_t count = open.size();
    std::make_heap(open.begin(), open.end(), less_error);
    while (sum.error > tolerance && count + 3 <= most_triangles) {
        execution.check();
        std::pop_heap(open.begin(), open.end(), less_error);
        const OuterTriangle whole = open.back();
        open.pop_back();
        sum.value -= whole.estimate.value;
        sum.error -= whole.estimate.error;
        for (OuterTriangle& part : quarters(whole)) {
            refine(part, tolerance * part.area / from.area, view);
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
