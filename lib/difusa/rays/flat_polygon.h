// Small convex polygons in space, clipped by planes without allocating memory.
#pragma once

#include <difusa/core/types.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

namespace difusa {

/// Points with normal·p > offset are above the plane.
struct Plane {
    Vec3 normal = Vec3::Zero();
    double offset = 0.0;

    /// In units of the normal's length; positive above.
    double height(const Vec3& p) const { return normal.dot(p) - offset; }

    /// The largest height of a box.
    double highest(const Eigen::AlignedBox3d& box) const {
        const auto corner = [&](int axis) { return normal[axis] >= 0.0 ? box.max()[axis] : box.min()[axis]; };
        return normal[0] * corner(0) + normal[1] * corner(1) + normal[2] * corner(2) - offset;
    }
};

/// A convex polygon in a plane, counterclockwise seen from its front. Empty if it has fewer than three corners.
class FlatPolygon {
  public:
    /// Clipping once adds one corner at most; `halves` keeps polygons that are clipped often below this.
    static constexpr std::size_t capacity = 32;

    FlatPolygon() = default;
    explicit FlatPolygon(std::span<const Vec3> corners) {
        for (const Vec3& p : corners) {
            add(p);
        }
    }

    FlatPolygon(const FlatPolygon& other) : count_(other.count_) { // NOLINT: copies the corners that are filled
        std::copy_n(other.corner_.begin(), count_, corner_.begin());
    }
    FlatPolygon& operator=(const FlatPolygon& other) { // NOLINT: likewise; also of itself
        count_ = other.count_;
        std::copy_n(other.corner_.begin(), count_, corner_.begin());
        return *this;
    }
    ~FlatPolygon() = default;

    std::size_t size() const { return count_; }
    bool empty() const { return count_ < 3; }
    const Vec3& operator[](std::size_t k) const { return corner_[k]; }
    const Vec3& next(std::size_t k) const { return corner_[k + 1 < count_ ? k + 1 : 0]; }
    std::span<const Vec3> corners() const { return {corner_.data(), count_}; }

    /// At most `capacity` corners; more are left out.
    void add(const Vec3& p) {
        if (count_ < capacity) {
            corner_[count_++] = p;
        }
    }

    Vec3 mean_corner() const {
        Vec3 sum = Vec3::Zero();
        for (const Vec3& p : corners()) {
            sum += p;
        }
        return sum / static_cast<double>(count_);
    }

    /// Half the sum of the cross products of its edges: the unit normal times the area.
    Vec3 area_vector() const {
        Vec3 sum = Vec3::Zero();
        for (std::size_t k = 2; k < count_; ++k) {
            sum += (corner_[k - 1] - corner_[0]).cross(corner_[k] - corner_[0]);
        }
        return 0.5 * sum;
    }

    /// The part above a plane; corners within `rounding` (in units of Plane::height) of it count as on it. If `sign`
    /// is -1, the part below.
    FlatPolygon above(const Plane& plane, double rounding, double sign = 1.0) const {
        FlatPolygon kept;
        std::array<double, capacity> heights; // NOLINT: filled before use
        bool any = false;
        for (std::size_t k = 0; k < count_; ++k) {
            heights[k] = sign * plane.height(corner_[k]);
            any = any || heights[k] > rounding;
        }
        if (!any) {
            return kept;
        }
        for (std::size_t k = 0; k < count_; ++k) {
            const double at = heights[k], to = heights[k + 1 < count_ ? k + 1 : 0];
            if (at >= -rounding) {
                kept.add(corner_[k]);
            }
            if ((at < -rounding && to > rounding) || (at > rounding && to < -rounding)) {
                kept.add(corner_[k] + at / (at - to) * (next(k) - corner_[k]));
            }
        }
        if (kept.count_ < 3) {
            kept.count_ = 0;
        }
        return kept;
    }

    /// The two parts on either side of the diagonal between the first corner and the one opposite.
    std::array<FlatPolygon, 2> halves() const {
        std::array<FlatPolygon, 2> parts;
        const std::size_t middle = count_ / 2;
        for (std::size_t k = 0; k <= middle; ++k) {
            parts[0].add(corner_[k]);
        }
        parts[1].add(corner_[0]);
        for (std::size_t k = middle; k < count_; ++k) {
            parts[1].add(corner_[k]);
        }
        return parts;
    }

  private:
    std::array<Vec3, capacity> corner_; // NOLINT: the first count_ are filled
    std::size_t count_ = 0;
};

} // namespace difusa
