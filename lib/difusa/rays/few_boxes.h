// A few boxes around parts of a surface, and which rays may meet what is in them.
#pragma once

#include <difusa/core/types.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

namespace difusa {

/// Boxes that hold others: those that touch are united, and then those that are nearest to each other until there are
/// few. They are grown by more than hits and the test round by, so that a ray that meets a face in one of them meets
/// the box.
class FewBoxes {
  public:
    using Box = Eigen::AlignedBox3d;

    FewBoxes() = default;

    /// `magnitude`: of the coordinates of the surface (Mesh::magnitude).
    FewBoxes(std::vector<Box> boxes, double magnitude);

    std::span<const Box> boxes() const { return boxes_; }

    /// Replaces `above` by those that are not wholly below the plane through `foot` with this unit normal.
    void above(const Vec3& foot, const Vec3& normal, std::vector<Box>& above) const;

  private:
    std::vector<Box> boxes_;
    double margin_ = 0.0;
};

/// A box seen from one place: whether rays from there meet it. Most are ruled out by the cone around its bounding
/// sphere.
class BoxFrom {
  public:
    BoxFrom(const FewBoxes::Box& box, const Vec3& origin) : box_(box), origin_(origin), way_(box.center() - origin) {
        const double radius2 = 0.25 * box.sizes().squaredNorm(), distance2 = way_.squaredNorm();
        if (distance2 > radius2) {
            least_ = std::sqrt(distance2 - radius2) - rounding * std::sqrt(distance2);
        }
    }

    /// Whether the ray of this unit direction meets the box.
    bool is_met(const Vec3& direction) const { return direction.dot(way_) >= least_ && meets(direction); }

  private:
    static constexpr double rounding = 1e-7; ///< of the tangent to the sphere, over the distance: half of all digits

    bool meets(const Vec3& direction) const {
        double enter = 0.0, leave = std::numeric_limits<double>::infinity();
        for (Eigen::Index axis = 0; axis < 3; ++axis) {
            // NaN, where the ray runs within a side, decides nothing that matters: sides are beyond all faces.
            const double a = (box_.min()[axis] - origin_[axis]) / direction[axis],
                         b = (box_.max()[axis] - origin_[axis]) / direction[axis];
            enter = std::max(enter, std::min(a, b));
            leave = std::min(leave, std::max(a, b));
        }
        return enter <= leave;
    }

    FewBoxes::Box box_;
    Vec3 origin_, way_;
    double least_ = -std::numeric_limits<double>::infinity(); ///< length of the tangent to the sphere, if there is one
};

} // namespace difusa
