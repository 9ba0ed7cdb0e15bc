// Kernel `disc` (M eq. 4): F A = cosθ_x cosθ_y A / (pi r² + A), the patch as a disc of equal area facing the receiver.
// Bounded by the cosines as r goes to 0; equals the point kernel far away.
#include <difusa/plugin/plugin.h>
#include <difusa/transport/kernel.h>

#include <algorithm>
#include <numbers>

namespace {

class DiscKernel final : public difusa::Kernel {
  public:
    explicit DiscKernel(const difusa::Parameters& /*parameters*/) {}
    double form_factor(const difusa::Vec3& x, const difusa::Vec3& n_x, const difusa::Vec3& y, const difusa::Vec3& n_y,
                       double A) const override {
        const difusa::Vec3 w = y - x;
        const double r2 = w.squaredNorm();
        if (r2 == 0.0) {
            return 0.0;
        }
        const double cosines = std::max(0.0, n_x.dot(w)) * std::max(0.0, -n_y.dot(w)) / r2;
        return cosines * A / (std::numbers::pi * r2 + A);
    }
};

} // namespace

DIFUSA_PLUGIN(kernel, "disc", DiscKernel, "Point-to-disc form factor (M eq. 4): bounded at short range.", {})
