// A plugin made with an interface version that does not exist. When its code runs after all, be it the initializer
// of a global object, it leaves a file.
#include <difusa/plugin/plugin.h>
#include <difusa/transport/kernel.h>

#include <cstdlib>
#include <fstream>

#undef DIFUSA_INTERFACE_VERSION
#define DIFUSA_INTERFACE_VERSION 999999

namespace {

struct Marker {
    Marker() {
        if (const char* const file = std::getenv("DIFUSA_TEST_MARKER")) {
            std::ofstream(file) << "code of a refused module ran\n";
        }
    }
};

const Marker marker;

class WrongVersion final : public difusa::Kernel {
  public:
    explicit WrongVersion(const difusa::Parameters& /*parameters*/) {}
    double form_factor(const difusa::Vec3& /*x*/, const difusa::Vec3& /*n_x*/, const difusa::Vec3& /*y*/,
                       const difusa::Vec3& /*n_y*/, double /*A*/) const override {
        return 0.0;
    }
};

} // namespace

DIFUSA_PLUGIN(kernel, "wrong-version", WrongVersion, "From the future.", {})
