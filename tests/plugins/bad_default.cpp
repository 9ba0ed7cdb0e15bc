// A plugin whose declared default its own declaration forbids.
#include <difusa/plugin/plugin.h>
#include <difusa/transport/kernel.h>

namespace {

class BadDefault final : public difusa::Kernel {
  public:
    explicit BadDefault(const difusa::Parameters& /*parameters*/) {}
    double form_factor(const difusa::Vec3& /*x*/, const difusa::Vec3& /*n_x*/, const difusa::Vec3& /*y*/,
                       const difusa::Vec3& /*n_y*/, double /*A*/) const override {
        return 0.0;
    }
};

} // namespace

DIFUSA_PLUGIN(kernel, "bad-default", BadDefault, "Contradicts itself.",
              {{"width", difusa::ParameterSpec::Type::real, "2", "must be at most 1, and is 2", 0.0, 1.0, {}}})
