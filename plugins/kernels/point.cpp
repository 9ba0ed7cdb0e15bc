// Kernel `point` (T 5.2): F A = cosθ_x cosθ_y A / (pi r²), the patch as if all of its area were at one point.
// Unbounded: it exceeds 1 when r is below the size of the patch, and is kept here as printed.
#include <difusa/plugin/plugin.h>
#include <difusa/transport/kernel.h>

#include <algorithm>
#include <numbers>

namespace {

class PointKernel final : public difusa::Kernel {
  public:
    explicit PointKernel(const difusa::Parameters& /*parameters*/) {}
    double form_factor(const difusa::Vec3& x, const difusa::Vec3& n_x, const difusa::Vec3& y, const difusa::Vec3& n_y,
                       double A) const override {
        const difusa::Vec3 w = y - x;
        const double r2 = w.squaredNorm();
        if (r2 == 0.0) {
            return 0.0;
        }
        return std::max(0.0, n_x.dot(w)) * std::max(0.0, -n_y.dot(w)) * A / (std::numbers::pi * r2 * r2);
    }
};

} // namespace

DIFUSA_PLUGIN(kernel, "point", PointKernel, "Point-to-point form factor times area (T 5.2); unbounded at short range.",
              {})
