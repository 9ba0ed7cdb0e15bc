// Where the shadow of an obstacle may fall: no sample point need be in it.
#pragma once

#include <difusa/form_factors/unblocked.h>

#include <array>
#include <span>
#include <vector>

namespace difusa {

/// Coordinates in the plane of a polygon.
class PlaneFrame {
  public:
    using Point = Eigen::Vector2d;

    PlaneFrame() = default;
    explicit PlaneFrame(const PolygonEnd& polygon);

    Point flat(const Vec3& x) const { return {across_.dot(x - origin_), along_.dot(x - origin_)}; }
    Vec3 lifted(const Point& x) const { return origin_ + x.x() * across_ + x.y() * along_; }

  private:
    Vec3 origin_ = Vec3::Zero(), across_ = Vec3::UnitX(), along_ = Vec3::UnitY();
};

/// The points of the plane of one polygon, `from`, from which a convex obstacle may hide something of another one,
/// `to`: those that a segment from `to` through the obstacle reaches. They are a convex set: the hull of the points to
/// which the corners of `to` project those of the obstacle, if all corners of the obstacle are lower than those of
/// `to`. Where they are not, the set extends to infinity, and is cut off far away.
class ShadowRegion {
  public:
    using Point = PlaneFrame::Point;

    /// `frame`: of `from`; `obstacle`: corners of the obstacle, or of anything that contains it, the plane of `from`
    /// passing through it or not; `to`: corners of what is seen. Keeps no references.
    ShadowRegion(const PlaneFrame& frame, const PolygonEnd& from, std::span<const Vec3> to,
                 std::span<const Vec3> obstacle);

    /// What of it is in a triangle of the plane.
    struct Part {
        double area = 0.0; ///< 0: nothing
        Point centre = Point::Zero();
        std::array<Point, 3> aside{}; ///< half-way from there to some of its corners
    };
    /// The triangle: counterclockwise as seen from the front.
    Part within(const std::array<Point, 3>& triangle) const;

  private:
    void extend(const std::vector<Point>& behind, const std::vector<Point>& directions, double far);
    void take_hull();

    std::vector<Point> outline_;                       ///< convex, counterclockwise; may be empty
    Point low_ = Point::Zero(), high_ = Point::Zero(); ///< bounding box
    mutable std::vector<Point> inside_, kept_;
};

} // namespace difusa
