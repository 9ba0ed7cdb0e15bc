// A visibility engine of the name embree that cannot be started, as on a machine whose processor Embree refuses.
#include <difusa/core/error.h>
#include <difusa/plugin/plugin.h>
#include <difusa/rays/visibility.h>

namespace {

class IdleEmbree final : public difusa::Visibility {
  public:
    explicit IdleEmbree(const difusa::Parameters& /*parameters*/) {
        throw difusa::ResourceError("it cannot be started");
    }
    void build(const difusa::Mesh& /*mesh*/) override {}
    void first_hits(std::span<const difusa::Ray> /*rays*/, std::span<difusa::Hit> /*hits*/) const override {}
    void occluded(std::span<const difusa::Segment> /*segments*/, std::span<std::uint8_t> /*blocked*/) const override {}
};

} // namespace

DIFUSA_PLUGIN(visibility, "embree", IdleEmbree, "Cannot be started.", {})
