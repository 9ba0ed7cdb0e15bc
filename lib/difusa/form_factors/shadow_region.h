// Where the shadow of an obstacle may fall: no sample point need be in it.
#pragma once

#include <difusa/form_factors/unblocked.h>

#include <span>
#include <vector>

namespace difusa {

/// The points of the plane of one polygon, `from`, from which an obstacle may hide something of another one, `to`:
/// those that a segment from `to` through the obstacle reaches. It is convex, and for a convex obstacle that is lower
/// than all of `to` the hull of what the corners of `to` project the obstacle's corners to. Where it is higher, the
/// region has no end, and is cut off far away.
class ShadowRegion {
  public:
    /// `obstacle`: its corners; it is between the planes of both polygons. Keeps no references.
    ShadowRegion(const PolygonEnd& from, const PolygonEnd& to, std::span<const Vec3> obstacle);

    /// What of it is in a triangle of the plane.
    struct Part {
        double area = 0.0; ///< 0: nothing
        Vec3 centre = Vec3::Zero();
    };
    /// The triangle: a corner, and the other two relative to it, counterclockwise as seen from the front.
    Part within(const Vec3& corner, const Vec3& first, const Vec3& second) const;

  private:
    using Point = Eigen::Vector2d;

    Point flat(const Vec3& x) const { return {across_.dot(x - origin_), along_.dot(x - origin_)}; }
    void take_hull();

    Vec3 origin_, across_, along_; ///< of coordinates in the plane
    std::vector<Point> outline_;   ///< convex, counterclockwise
    Point low_, high_;             ///< bounding box
    mutable std::vector<Point> inside_, kept_;
};

} // namespace difusa
