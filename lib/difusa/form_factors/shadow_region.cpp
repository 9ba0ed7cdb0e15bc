#include <difusa/form_factors/shadow_region.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>

namespace difusa {

namespace {

/// A region without end is cut off at so many times the distance of the obstacle from `to`.
constexpr double far = 1e3;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() * b.y() - a.y() * b.x();
}

} // namespace

ShadowRegion::ShadowRegion(const PolygonEnd& from, const PolygonEnd& to, std::span<const Vec3> obstacle)
    : origin_(from.centre), across_(from.plane.normal.unitOrthogonal()), along_(from.plane.normal.cross(across_)) {
    for (const Vec3& p : obstacle) {
        const Point foot = flat(p);
        const double low = from.plane.height(p);
        for (const Vec3& t : to.polygon.corners()) {
            const Point end = flat(t);
            const double high = from.plane.height(t);
            const double times = high - low > high / far ? high / (high - low) : far;
            outline_.emplace_back(end + times * (foot - end));
        }
    }
    take_hull();
}

/// The convex hull of the points that are in `outline_` (A. M. Andrew 1979).
void ShadowRegion::take_hull() {
    std::vector<Point>& points = outline_;
    std::sort(points.begin(), points.end(),
              [](const Point& a, const Point& b) { return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y()); });
    std::vector<Point> hull;
    const auto add = [&](const Point& next, std::size_t least) {
        while (hull.size() >= least && cross(hull.back() - hull[hull.size() - 2], next - hull.back()) <= 0.0) {
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
    low_ = high_ = points.front();
    for (const Point& point : points) {
        low_ = low_.cwiseMin(point);
        high_ = high_.cwiseMax(point);
    }
}

ShadowRegion::Part ShadowRegion::within(const Vec3& corner, const Vec3& first, const Vec3& second) const {
    const std::array<Point, 3> triangle{flat(corner), flat(corner + first), flat(corner + second)};
    const Point low = triangle[0].cwiseMin(triangle[1]).cwiseMin(triangle[2]),
                high = triangle[0].cwiseMax(triangle[1]).cwiseMax(triangle[2]);
    if ((low.array() >= high_.array()).any() || (high.array() <= low_.array()).any()) {
        return {};
    }
    inside_ = outline_;
    for (std::size_t side = 0; side < 3 && inside_.size() > 2; ++side) {
        const Point &begin = triangle[side], along = triangle[(side + 1) % 3] - begin;
        const auto height = [&](const Point& x) { return cross(along, x - begin); };
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
        const double each = cross(inside_[k - 1] - inside_[0], inside_[k] - inside_[0]);
        twice += each;
        moment += each / 3.0 * (inside_[0] + inside_[k - 1] + inside_[k]);
    }
    if (!(twice > 0.0)) {
        return {};
    }
    const Point centre = moment / twice;
    return {0.5 * twice, origin_ + centre.x() * across_ + centre.y() * along_};
}

} // namespace difusa
