// Small convex polygons in the plane, clipped by straight lines.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace difusa {

/// Counterclockwise, at most 16 corners; empty if fewer than 3 remain.
struct ConvexPolygon {
    std::array<Eigen::Vector2d, 16> corner{};
    std::size_t count = 0;

    ConvexPolygon() { corner.fill(Eigen::Vector2d::Zero()); }

    void add(const Eigen::Vector2d& p) {
        if (count < corner.size()) {
            corner[count++] = p;
        }
    }

    /// The part where the affine function a + b·p is non-negative (Sutherland and Hodgman 1974).
    ConvexPolygon cut(double a, const Eigen::Vector2d& b) const {
        ConvexPolygon kept;
        for (std::size_t k = 0; k < count; ++k) {
            const Eigen::Vector2d &p = corner[k], &q = corner[(k + 1) % count];
            const double at_p = a + b.dot(p), at_q = a + b.dot(q);
            if (at_p >= 0.0) {
                kept.add(p);
            }
            if ((at_p < 0.0 && at_q > 0.0) || (at_p > 0.0 && at_q < 0.0)) {
                kept.add(p + at_p / (at_p - at_q) * (q - p));
            }
        }
        if (kept.count < 3) {
            kept.count = 0;
        }
        return kept;
    }

    double area() const {
        double twice = 0.0;
        for (std::size_t k = 2; k < count; ++k) {
            twice += twice_area(k);
        }
        return 0.5 * twice;
    }

    /// The centroid; the mean of the corners if the area is 0.
    Eigen::Vector2d centroid() const {
        Eigen::Vector2d sum = Eigen::Vector2d::Zero(), mean = sum;
        double weight = 0.0;
        for (std::size_t k = 2; k < count; ++k) {
            const double w = twice_area(k);
            sum += w / 3.0 * (corner[0] + corner[k - 1] + corner[k]);
            weight += w;
        }
        for (std::size_t k = 0; k < count; ++k) {
            mean += corner[k] / static_cast<double>(count);
        }
        return weight > 0.0 ? Eigen::Vector2d(sum / weight) : mean;
    }

    /// A point distributed uniformly by area if s and t are uniform in [0, 1).
    Eigen::Vector2d at(double s, double t) const {
        const double wanted = s * 2.0 * area();
        double below = 0.0;
        for (std::size_t k = 2; k < count; ++k) {
            const double w = twice_area(k);
            if (wanted < below + w || k + 1 == count) {
                const double part = w > 0.0 ? std::clamp((wanted - below) / w, 0.0, 1.0) : 0.0;
                const double root = std::sqrt(part);
                return (1.0 - root) * corner[0] + root * (1.0 - t) * corner[k - 1] + root * t * corner[k];
            }
            below += w;
        }
        return corner[0];
    }

  private:
    double twice_area(std::size_t k) const {
        const Eigen::Vector2d a = corner[k - 1] - corner[0], b = corner[k] - corner[0];
        return a[0] * b[1] - a[1] * b[0];
    }
};

} // namespace difusa
