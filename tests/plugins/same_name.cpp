// Another plugin that claims the name of well_made.cpp, spelled with the other dash.
#include <difusa/plugin/plugin.h>
#include <difusa/transport/kernel.h>

namespace {

class SameName final : public difusa::Kernel {
  public:
    explicit SameName(const difusa::Parameters& /*parameters*/) {}
    double form_factor(const difusa::Vec3& /*x*/, const difusa::Vec3& /*n_x*/, const difusa::Vec3& /*y*/,
                       const difusa::Vec3& /*n_y*/, double /*A*/) const override {
        return -1.0;
    }
};

} // namespace

DIFUSA_PLUGIN(kernel, "well_made", SameName, "Comes too late.", {})
