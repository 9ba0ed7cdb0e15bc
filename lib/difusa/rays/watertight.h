// Gap-free ray-triangle intersection: a ray through a shared edge or vertex hits at least one of the triangles there.
// Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013.
#pragma once

#include <difusa/core/types.h>

#include <cmath>
#include <utility>

namespace difusa {

/// A ray prepared for many triangles: axes permuted so that z is the largest component of the direction, and a shear
/// that maps the direction to the z axis.
class WatertightRay {
  public:
    WatertightRay(const Vec3& origin, const Vec3& direction) : origin_(origin) {
        direction.cwiseAbs().maxCoeff(&z_);
        x_ = (z_ + 1) % 3;
        y_ = (x_ + 1) % 3;
        if (direction[z_] < 0.0) {
            std::swap(x_, y_); // keeps the winding
        }
        shear_z_ = 1.0 / direction[z_];
        shear_x_ = direction[x_] * shear_z_;
        shear_y_ = direction[y_] * shear_z_;
    }

    /// Bound on the error of `meets`, as a length across the ray, for triangles inside the box [low, high]. The sheared
    /// coordinates of a corner are rounded by less than 6 units of 2^-53 of its distance from the origin, and the edge
    /// functions by as much again; this is twice the sum.
    static double rounding(const Vec3& origin, const Vec3& low, const Vec3& high) {
        return 0x1p-48 * (origin - low).cwiseAbs().cwiseMax((origin - high).cwiseAbs()).maxCoeff();
    }

    /// The intersection of the ray with the triangle abc.
    struct Meeting {
        double t = 0.0; ///< position = origin + t direction; may be negative
        double u = 0.0, v = 0.0;
        bool front = false; ///< against the normal (b-a)×(c-a)
    };

    /// True if the line of the ray passes through the triangle (border included) at any t. A triangle seen edge-on is
    /// not hit: its neighbours, or the faces of the solid it belongs to, are.
    bool meets(const Vec3& a, const Vec3& b, const Vec3& c, Meeting& meeting) const {
        const double az = a[z_] - origin_[z_], bz = b[z_] - origin_[z_], cz = c[z_] - origin_[z_];
        const double ax = (a[x_] - origin_[x_]) - shear_x_ * az, ay = (a[y_] - origin_[y_]) - shear_y_ * az;
        const double bx = (b[x_] - origin_[x_]) - shear_x_ * bz, by = (b[y_] - origin_[y_]) - shear_y_ * bz;
        const double cx = (c[x_] - origin_[x_]) - shear_x_ * cz, cy = (c[y_] - origin_[y_]) - shear_y_ * cz;
        // Each edge function is a difference of two rounded products: exactly opposite for the two triangles sharing an
        // edge, so that both cannot be missed.
        const double U = cx * by - cy * bx;
        const double V = ax * cy - ay * cx;
        const double W = bx * ay - by * ax;
        if ((U < 0.0 || V < 0.0 || W < 0.0) && (U > 0.0 || V > 0.0 || W > 0.0)) {
            return false;
        }
        const double det = U + V + W;
        if (det == 0.0) {
            return false;
        }
        const double inverse = 1.0 / det;
        meeting.t = shear_z_ * (U * az + V * bz + W * cz) * inverse;
        meeting.u = V * inverse;
        meeting.v = W * inverse;
        meeting.front = det > 0.0;
        return true;
    }

  private:
    Vec3 origin_;
    Eigen::Index x_ = 0, y_ = 0, z_ = 0;
    double shear_x_ = 0.0, shear_y_ = 0.0, shear_z_ = 1.0;
};

} // namespace difusa
