// A few boxes around parts of a surface, and which rays may meet what is in them.
#pragma once

#include <difusa/core/types.h>

#include <Eigen/Geometry>

#include <algorithm>
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

/// A ray whose way through boxes is asked for.
class RayThroughBoxes {
  public:
    RayThroughBoxes(const Vec3& origin, const Vec3& direction) : origin_(origin), inverse_(direction.cwiseInverse()) {}

    bool meets(const FewBoxes::Box& box) const {
        double enter = 0.0, leave = std::numeric_limits<double>::infinity();
        for (Eigen::Index axis = 0; axis < 3; ++axis) {
            // NaN, where the ray runs within a side, decides nothing that matters: sides are beyond all faces.
            const double a = (box.min()[axis] - origin_[axis]) * inverse_[axis],
                         b = (box.max()[axis] - origin_[axis]) * inverse_[axis];
            enter = std::max(enter, std::min(a, b));
            leave = std::min(leave, std::max(a, b));
        }
        return enter <= leave;
    }

    bool meets_any(std::span<const FewBoxes::Box> boxes) const {
        return std::any_of(boxes.begin(), boxes.end(), [this](const FewBoxes::Box& box) { return meets(box); });
    }

  private:
    Vec3 origin_, inverse_;
};

} // namespace difusa
