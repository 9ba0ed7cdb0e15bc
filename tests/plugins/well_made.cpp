// A plugin as it should be; its parameters come back through the form factor. Nine times, it cannot be made.
#include <difusa/plugin/plugin.h>
#include <difusa/transport/kernel.h>

#include <stdexcept>

namespace {

class WellMade final : public difusa::Kernel {
  public:
    explicit WellMade(const difusa::Parameters& parameters)
        : factor_(parameters.real("factor") * static_cast<double>(parameters.integer("times"))) {
        if (parameters.integer("times") == 9) {
            throw std::runtime_error("no licence");
        }
    }

    double form_factor(const difusa::Vec3& /*x*/, const difusa::Vec3& /*n_x*/, const difusa::Vec3& /*y*/,
                       const difusa::Vec3& /*n_y*/, double A) const override {
        return factor_ * A;
    }

  private:
    double factor_;
};

} // namespace

DIFUSA_PLUGIN(kernel, "well-made", WellMade, "A factor times the area.",
              {{"factor", difusa::ParameterSpec::Type::real, "0.5", "the factor", 0.0, 8.0, {}},
               {"times", difusa::ParameterSpec::Type::integer, "1", "how often it is applied", 1, 9, {}}})
