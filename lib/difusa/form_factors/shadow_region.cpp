#include <difusa/form_factors/shadow_region.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace difusa {

namespace {

/// A region without end is cut off at least so many times the radius of `from` beyond it.
constexpr double far_away = 100.0;

/// Heights that differ by less than this share of them are the same: what is projected is at infinity.
constexpr double same_height = 1e-9;

double cross_product(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() * b.y() - a.y() * b.x();
}

} // namespace

PlaneFrame::PlaneFrame(const PolygonEnd& polygon)
    : origin_(polygon.centre), across_(polygon.plane.normal.unitOrthogonal()),
      along_(polygon.plane.normal.cross(across_)) {}

/// The segment from t at height h_t through p at height h_p reaches the plane at t + h_t / (h_t - h_p) (p - t): before
/// the plane if p is lower than t, else behind t, or never. The points that p, and obstacle corners that are not lower,
/// have between them in projective space are those beyond the former, away from the latter.
ShadowRegion::ShadowRegion(const PlaneFrame& frame, const PolygonEnd& from, std::span<const Vec3> to,
                           std::span<const Vec3> obstacle) {
    std::vector<Point> behind, directions;
    for (const Vec3& p : obstacle) {
        const Point foot = frame.flat(p);
        const double low = from.plane.height(p);
        for (const Vec3& t : to) {
            const Point end = frame.flat(t), way = foot - end;
            const double high = from.plane.height(t), above = high - low;
            const double rounding = same_height * std::max(std::abs(high), std::abs(low));
            if (above > rounding) {
                outline_.emplace_back(end + high / above * way);
            } else if (above < -rounding) {
                behind.emplace_back(end + high / above * way);
            } else {
                directions.push_back(way);
            }
        }
    }
    extend(behind, directions, far_away * from.radius);
    if (!outline_.empty()) {
        take_hull();
    }
}

/// Adds points far away in the directions in which the region has no end.
void ShadowRegion::extend(const std::vector<Point>& behind, const std::vector<Point>& directions, double far) {
    const std::size_t finite = outline_.size();
    for (std::size_t k = 0; k < finite; ++k) {
        const Point x = outline_[k];
        const double beyond = far + 2.0 * x.norm(); // also from the other side of `from`
        const auto add = [&](const Point& direction) {
            const double length = direction.norm();
            if (length > 0.0) {
                outline_.emplace_back(x + beyond / length * direction);
            }
        };
        for (const Point& other : behind) {
            add(x - other);
        }
        for (const Point& direction : directions) {
            add(direction);
        }
    }
}

/// The convex hull of the points that are in `outline_` (A. M. Andrew 1979).
void ShadowRegion::take_hull() {
    std::vector<Point>& points = outline_;
    std::sort(points.begin(), points.end(),
              [](const Point& a, const Point& b) { return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y()); });
    std::vector<Point> hull;
    const auto add = [&](const Point& next, std::size_t least) {
        while (hull.size() >= least && cross_product(hull.back() - hull[hull.size() - 2], next - hull.back()) <= 0.0) {
            hull.pop_back();
        }
        hull.push_back(next);
    };
    for (const Point& next : points) {
        add(next, 2);
    }
    const std::size_t least = hull.size() + 1;
    for (std::size_t k = points.size() - 1; k-- > 0;) {
        add(points[k], least);
    }
    hull.pop_back(); // the first point again
    points.swap(hull);
    if (points.empty()) { // they were all the same
        return;
    }
    low_ = high_ = points.front();
    for (const Point& point : points) {
        low_ = low_.cwiseMin(point);
        high_ = high_.cwiseMax(point);
    }
}

ShadowRegion::Part ShadowRegion::within(const std::array<Point, 3>& triangle) const {
    const Point low = triangle[0].cwiseMin(triangle[1]).cwiseMin(triangle[2]),
                high = triangle[0].cwiseMax(triangle[1]).cwiseMax(triangle[2]);
    if (outline_.size() < 3 || (low.array() >= high_.array()).any() || (high.array() <= low_.array()).any()) {
        return {};
    }
    inside_ = outline_;
    for (std::size_t side = 0; side < 3 && inside_.size() > 2; ++side) {
        const Point &begin = triangle[side], along = triangle[(side + 1) % 3] - begin;
        const auto height = [&](const Point& x) { return cross_product(along, x - begin); };
        kept_.clear();
        for (std::size_t k = 0; k < inside_.size(); ++k) {
            const Point &a = inside_[k], &b = inside_[k + 1 < inside_.size() ? k + 1 : 0];
            const double at_a = height(a), at_b = height(b);
            if (at_a >= 0.0) {
                kept_.push_back(a);
            }
            if ((at_a > 0.0 && at_b < 0.0) || (at_a < 0.0 && at_b > 0.0)) {
                kept_.emplace_back(a + at_a / (at_a - at_b) * (b - a));
            }
        }
        inside_.swap(kept_);
    }
    double twice = 0.0;
    Point moment = Point::Zero();
    for (std::size_t k = 2; k < inside_.size(); ++k) {
        const double each = cross_product(inside_[k - 1] - inside_[0], inside_[k] - inside_[0]);
        twice += each;
        moment += each / 3.0 * (inside_[0] + inside_[k - 1] + inside_[k]);
    }
    if (!(twice > 0.0)) {
        return {};
    }
    Part part{0.5 * twice, moment / twice, {}};
    for (std::size_t k = 0; k < part.aside.size(); ++k) {
        part.aside[k] = 0.5 * (part.centre + inside_[k * inside_.size() / part.aside.size()]);
    }
    return part;
}

} // namespace difusa
